"""From a capture and the path to thickness."""
