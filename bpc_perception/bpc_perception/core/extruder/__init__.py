"""What the extruder reports, and what that means for the ink."""
