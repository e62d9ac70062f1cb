"""Step 2: what ink and bed look like, and how much of each sample is ink."""
