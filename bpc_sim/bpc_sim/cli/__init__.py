"""The commands of the simulator: registered for ``bpc`` as entry points."""
