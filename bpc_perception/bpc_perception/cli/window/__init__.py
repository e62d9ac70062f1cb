"""``bpc window``: its command and its tables."""
