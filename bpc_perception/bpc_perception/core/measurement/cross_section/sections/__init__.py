"""Step 1: sections laid across the path, and what is seen along them."""
