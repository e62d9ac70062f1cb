"""Speed; each benchmark verifies that results are right before it times them."""
