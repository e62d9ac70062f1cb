"""What is to be mended of a finished layer, and whether the next one can be laid on it."""
