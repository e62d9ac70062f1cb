"""Benchmarks: each verifies that results agree, then times; see ``./bpc bench``."""
