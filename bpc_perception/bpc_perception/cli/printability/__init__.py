"""``bpc printability``: its command, where a print comes from, and its tables."""
