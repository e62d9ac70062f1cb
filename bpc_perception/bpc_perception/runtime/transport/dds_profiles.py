"""Choose the Fast DDS profile of a process: where it listens, how much memory it shares.

When discovery is limited to this computer, our profiles also listen on this computer only. By
default Fast DDS binds its ports to all interfaces, and takes messages from anyone who knows them.
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

# Fast DDS reads the name of a profile from any of these.
PROFILE_VARIABLES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
DISCOVERY_RANGE_VARIABLE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
FOLDER = Path(__file__).parent
# By (for this computer only, for a process that publishes captures).
PROFILES = {(True, True): FOLDER / 'local_transport.xml', (True, False): FOLDER / 'local.xml',
            (False, True): FOLDER / 'transport.xml', (False, False): FOLDER / 'network.xml'}
# The port for messages is 7400 + 250 domain + 2 participant + an offset, by default 11. With up to
# 32 participants and one of these offsets it is among the 250 ports of its domain.
PORT_OFFSETS = range(11, 188, 2)


def users_profile(environment: Mapping[str, str]) -> str:
    """Return the profile that the user has chosen; empty if it is one of ours, or none."""
    given = _profile(environment)
    return '' if Path(given) in PROFILES.values() else given


def _profile(environment: Mapping[str, str]) -> str:
    """Return the profile that Fast DDS would read; empty if none."""
    return next((environment[name] for name in PROFILE_VARIABLES if environment.get(name)), '')


def with_profile(environment: Mapping[str, str], captures: bool = False) -> dict[str, str]:
    """Return the environment with our profile for a process; a user's own profile wins."""
    if users_profile(environment):
        return dict(environment)
    profile = PROFILES[environment.get(DISCOVERY_RANGE_VARIABLE) == 'LOCALHOST', captures]
    return {**environment, **dict.fromkeys(PROFILE_VARIABLES, str(profile))}


def choose_profile(captures: bool = False) -> None:
    """Set the profile of this process; call it before ROS starts."""
    os.environ.update(with_profile(os.environ, captures))


def lost_captures_hint() -> str:
    """Return what to do where image or cloud of captures get lost on their way."""
    profile = PROFILES[os.environ.get(DISCOVERY_RANGE_VARIABLE) == 'LOCALHOST', True]
    return ("they get lost where the camera's node has too little shared memory: start it with "
            f'{" and ".join(PROFILE_VARIABLES)} set to {profile}')


@contextmanager
def receive_profile(large_messages: bool) -> Iterator[None]:
    """Let the participant made in the block listen where killed processes harm it least.

    Large messages: it listens through shared memory, on another port than processes before it.
    Otherwise a process that replaces a killed one also takes its port. It then hears no process
    that wrote to the killed one until that process notices, 3 s later. The process never notices
    if the other was killed between waiting for a message and reading it [Fast DDS 2.14, WatchTask
    in SharedMemGlobal.hpp; issue 5053, pull request 4728].

    Other messages: it listens by UDP only. A process that is killed while it wakes a listener in
    shared memory leaves a lock. The listener, the processes that write to it and those that answer
    it then wait 1 s for the lock [Fast DDS 2.14, notify_one in RobustInterprocessCondition.hpp].

    A profile that has ports or locators itself, or no UDP, is left as it is.
    """
    with ExitStack() as stack:
        # If the profile cannot be read or a new one not written, Fast DDS listens as by default.
        with suppress(OSError, UnicodeDecodeError):
            stack.enter_context(_replaced_profile(large_messages))
        yield


@contextmanager
def _replaced_profile(large_messages: bool) -> Iterator[None]:
    """Replace the profile of this process, in the block, by a copy that says where to listen."""
    given = _profile(os.environ)
    text = Path(given).read_text() if given else ''
    where = _where_to_listen(text, large_messages)
    if not (given and where):
        yield
        return
    with NamedTemporaryFile(prefix='bpc_', suffix='.xml', dir=SHARED_MEMORY) as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # otherwise it looks like the file of a killed process
        Path(file.name).write_text(text.replace('<rtps>', f'<rtps>{where}'))
        os.environ.update(dict.fromkeys(PROFILE_VARIABLES, file.name))
        try:
            yield
        finally:
            os.environ.update(dict.fromkeys(PROFILE_VARIABLES, given))


def _where_to_listen(profile: str, large_messages: bool) -> str:
    """Return the elements that say where to listen; empty if the profile has such itself."""
    if '<port>' in profile or '<defaultUnicastLocatorList>' in profile:
        return ''
    if large_messages or 'UDPv4' not in profile:
        return f'<port><offsetd3>{secrets.choice(PORT_OFFSETS)}</offsetd3></port>'
    return ('<defaultUnicastLocatorList><locator><udpv4/></locator>'
            '</defaultUnicastLocatorList>')
