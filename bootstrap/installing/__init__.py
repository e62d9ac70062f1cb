"""Installs what the locks name: at first what all need, the rest when a command needs it."""
