"""Robot and extruder of the synthetic printer, on the topics of the real ones."""
