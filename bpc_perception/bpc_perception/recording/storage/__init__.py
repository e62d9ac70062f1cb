"""The files of a recording: which they are, and what lies in them."""
