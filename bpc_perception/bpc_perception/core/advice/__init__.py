"""From measured thickness to rate advice."""
