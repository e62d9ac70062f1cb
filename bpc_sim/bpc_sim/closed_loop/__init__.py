"""Prints that go wrong, and the controllers that correct them."""
