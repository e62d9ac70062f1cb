"""Runs the command line as ``python -m bpc_perception.cli``."""

from bpc_perception.cli import main

main()
