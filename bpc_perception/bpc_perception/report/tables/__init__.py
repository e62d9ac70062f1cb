"""Tables for other programs, with what each column means."""
