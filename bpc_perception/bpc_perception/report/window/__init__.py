"""The window of an ink as people read it: tables, a page, and a figure for papers."""
