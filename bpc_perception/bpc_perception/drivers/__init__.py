"""Devices: cameras and extruders, each behind one interface."""
