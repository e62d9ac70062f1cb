"""Speed, verified to be that of right results before it is timed."""
