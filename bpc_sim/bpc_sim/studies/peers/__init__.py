"""Other tools that measure width along a known path, beside both of our methods."""
