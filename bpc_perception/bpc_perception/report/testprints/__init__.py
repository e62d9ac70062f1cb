"""Judgements of test prints as people and scripts read them."""
