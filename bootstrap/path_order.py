"""Lets the packages of an environment win over those that the user has in PYTHONPATH.

A copy of this is in each environment, and a .pth file calls it whenever Python starts there.
"""

import os
import sys


def put_last(root: str) -> None:
    """Put the folders of PYTHONPATH that are outside a checkout behind all others."""
    given = os.environ.get('PYTHONPATH', '').split(os.pathsep)
    foreign = {
        os.path.abspath(folder)
        for folder in given
        if folder and not os.path.abspath(folder).startswith(root + os.sep)
    }
    sys.path.sort(key=lambda folder: folder in foreign)
