"""Runs the command line as ``python -m bpc_perception``."""

import sys

try:
    from bpc_perception.cli import main

    main()
except KeyboardInterrupt:  # while all of it is being loaded, which takes a second
    sys.exit(130)
