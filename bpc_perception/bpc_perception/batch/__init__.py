"""Many recordings measured at once."""
