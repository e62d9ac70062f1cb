"""Which of our profiles of Fast DDS a process gets: where it listens, how much memory it shares.

Where discovery is limited to this computer, nothing listens elsewhere either: by itself Fast DDS
binds its ports to all interfaces, and takes what comes there from whoever knows them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, ExitStack, suppress
import fcntl
import os
from pathlib import Path
import secrets
from tempfile import NamedTemporaryFile

from bpc_perception.runtime.transport.shared_memory import SHARED_MEMORY

# Read by Fast DDS under the one or the other name.
VARIABLES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
FOLDER = Path(__file__).parent
# Whether it is for this computer only, and for a process that publishes captures.
PROFILES = {(True, True): FOLDER / 'local_transport.xml', (True, False): FOLDER / 'local.xml',
            (False, True): FOLDER / 'transport.xml', (False, False): FOLDER / 'network.xml'}
# The port for messages is 7400 + 250 domain + 2 participant + an offset, by default 11. With up to
# 32 participants and one of these offsets it is among the 250 of its domain.
OFFSETS = range(11, 188, 2)


def users_profile(environment: Mapping[str, str]) -> str:
    """The profile that the user has chosen; empty where it is one of ours, or none."""
    given = _profile(environment)
    return '' if Path(given) in PROFILES.values() else given


def _profile(environment: Mapping[str, str]) -> str:
    """The one that Fast DDS would read; empty if none."""
    return next((environment[name] for name in VARIABLES if environment.get(name)), '')


def with_profile(environment: Mapping[str, str], captures: bool = False) -> dict[str, str]:
    """The environment of a process that publishes captures or not; a user's own profile wins."""
    if users_profile(environment):
        return dict(environment)
    profile = PROFILES[environment.get(RANGE) == 'LOCALHOST', captures]
    return {**environment, **dict.fromkeys(VARIABLES, str(profile))}


def choose_profile(captures: bool = False) -> None:
    """The same for this process, before it starts ROS."""
    os.environ.update(with_profile(os.environ, captures))


@contextmanager
def receive_profile(large_messages: bool) -> Iterator[None]:
    """Let the participant that is made meanwhile hear where who is killed harms it least.

    Large messages: through shared memory, on another port than those before it. Otherwise a
    process that takes the place of a killed one takes its port too, and hears nobody who wrote to
    that one before they find out, 3 s later. They never do if it was killed between waiting for a
    message and reading it [Fast DDS 2.14, WatchTask in SharedMemGlobal.hpp; issue 5053, pull
    request 4728].

    Others: by UDP alone. Whoever is killed while it wakes a listener in shared memory leaves a
    lock behind, for which the listener, who writes to it and who answers it wait 1 s [Fast DDS
    2.14, notify_one in RobustInterprocessCondition.hpp].

    A profile that says ports or locators itself, or no UDP, keeps what it says.
    """
    profile = _profile(os.environ)
    with ExitStack() as stack:
        # Where it cannot be read or there is no room, Fast DDS hears as it does by itself.
        with suppress(OSError, UnicodeDecodeError):
            if profile and (where := _where(text := Path(profile).read_text(), large_messages)):
                file = stack.enter_context(NamedTemporaryFile(
                    prefix='bpc_', suffix='.xml', dir=SHARED_MEMORY))
                fcntl.flock(file, fcntl.LOCK_EX)  # or else it passes for one of a killed process
                Path(file.name).write_text(text.replace('<rtps>', f'<rtps>{where}'))
                stack.callback(os.environ.update, dict.fromkeys(VARIABLES, profile))
                os.environ.update(dict.fromkeys(VARIABLES, file.name))
        yield


def _where(profile: str, large_messages: bool) -> str:
    """Where to hear, in the words of a profile; empty if this one says it itself."""
    if '<port>' in profile or '<defaultUnicastLocatorList>' in profile:
        return ''
    if large_messages or 'UDPv4' not in profile:
        return f'<port><offsetd3>{secrets.choice(OFFSETS)}</offsetd3></port>'
    return ('<defaultUnicastLocatorList><locator><udpv4/></locator>'
            '</defaultUnicastLocatorList>')
