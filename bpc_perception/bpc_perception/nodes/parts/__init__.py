"""Parts that several nodes share, or that are a piece of one."""
