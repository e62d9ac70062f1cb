"""Units, colours, words and pictures of results, the same wherever they are shown."""
