"""Prints as functions of time: robot, extruder, what has been laid, and recordings of them."""
