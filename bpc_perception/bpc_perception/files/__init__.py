"""Files that people write: calibrations and parameters."""
