"""The design of a print: what is wanted where, where it lies, and how far the print is from it."""
