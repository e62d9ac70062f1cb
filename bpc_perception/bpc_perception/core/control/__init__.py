"""Many prints of one kind: whether they stay alike, and how sure they are within tolerance."""
