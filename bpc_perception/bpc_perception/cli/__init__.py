"""The ``bpc`` command: a module a sub-command; app.py puts them together."""
