"""Printability as people read it: a table, and a figure for papers."""
