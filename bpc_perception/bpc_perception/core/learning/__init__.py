"""Learning from what repeats: a finished layer or print corrects the next of the same path."""
