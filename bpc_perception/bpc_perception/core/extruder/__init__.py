"""What the extruder says of itself, and what that means for the ink."""
