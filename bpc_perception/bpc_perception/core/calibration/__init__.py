"""The nozzle offset and the hand-eye calibration, found and checked."""
