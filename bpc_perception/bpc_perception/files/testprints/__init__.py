"""Files of test prints: the path as CSV and G-code, and the table of its strokes."""
