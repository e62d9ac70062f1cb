"""Verdicts on sound prints, and on prints with a defect of known kind and size."""
