"""Prints that are made to be measured: their paths, and what a recording of one tells."""
