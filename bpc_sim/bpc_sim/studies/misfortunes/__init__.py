"""A search for sequences of bad input that make advice rise where the truth does not allow it."""
