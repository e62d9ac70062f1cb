"""Robot, extruder and controller of the synthetic printer, on the topics of real ones."""
