"""Benchmarks of speed; each verifies that results are right before it times them."""
