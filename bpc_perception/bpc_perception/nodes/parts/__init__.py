"""What several nodes share, or is a piece of one."""
