"""Is the print good? Defects along it, and a verdict on each stroke, layer and the whole."""
