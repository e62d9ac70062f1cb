"""Prints that go wrong, with and without advice."""
