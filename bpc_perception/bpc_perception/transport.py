"""Which of our profiles of Fast DDS a process gets: where it listens, how much memory it shares.

Where discovery is limited to this computer, nothing listens elsewhere either: by itself Fast DDS
binds its ports to all interfaces, and takes what comes there from whoever knows them.
"""

from __future__ import annotations

from collections.abc import Mapping
import os
from pathlib import Path

# Read by Fast DDS under the one or the other name.
VARIABLES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
FOLDER = Path(__file__).parent
# Whether it is for this computer only, and for a process that publishes captures.
PROFILES = {(True, True): FOLDER / 'local_transport.xml', (True, False): FOLDER / 'local.xml',
            (False, True): FOLDER / 'transport.xml', (False, False): FOLDER / 'network.xml'}


def users_profile(environment: Mapping[str, str]) -> str:
    """The profile that the user has chosen; empty where it is one of ours, or none."""
    given = next((environment[name] for name in VARIABLES if environment.get(name)), '')
    return '' if Path(given) in PROFILES.values() else given


def with_profile(environment: Mapping[str, str], captures: bool = False) -> dict[str, str]:
    """The environment of a process that publishes captures or not; a user's own profile wins."""
    if users_profile(environment):
        return dict(environment)
    profile = PROFILES[environment.get(RANGE) == 'LOCALHOST', captures]
    return {**environment, **dict.fromkeys(VARIABLES, str(profile))}


def choose_profile(captures: bool = False) -> None:
    """The same for this process, before it starts ROS."""
    os.environ.update(with_profile(os.environ, captures))
