"""Whether inputs still arrive, and when to look for a device again."""
