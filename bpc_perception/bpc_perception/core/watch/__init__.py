"""Whether inputs go on, and when to look for a device again."""
