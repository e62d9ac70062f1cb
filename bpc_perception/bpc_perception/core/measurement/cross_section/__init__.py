"""The default method: the image read across the path."""
