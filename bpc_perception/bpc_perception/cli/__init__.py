"""The ``bpc`` command: a module a sub-command; app.py puts them together."""

import os

# As in the nodes, and for the same reason: threads for small matrices only take processor time.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
