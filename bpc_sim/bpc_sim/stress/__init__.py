"""Hard scenes of known truth."""
