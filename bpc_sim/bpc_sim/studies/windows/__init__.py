"""Windows of inks whose laws are known: whether the recommended setting meets the target."""
