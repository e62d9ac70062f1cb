"""The profiles of Fast DDS: which one is chosen, and where each process listens."""

from __future__ import annotations

import os
from pathlib import Path
import resource
from xml.etree import ElementTree

import pytest

from bpc_perception.runtime.transport import dds_profiles
from bpc_perception.runtime.transport.dds_profiles import (
    DISCOVERY_RANGE_VARIABLE,
    FOLDER,
    PROFILE_VARIABLES,
    PROFILES,
    receive_profile,
    with_profile,
)
from bpc_perception.runtime.transport.shared_memory import clean

NAMESPACE = {'dds': 'http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles'}


def test_profiles_differ_in_what_they_are_for_only() -> None:
    for (local, captures), file in PROFILES.items():
        root = ElementTree.parse(file).getroot()
        assert [each.text for each in root.iterfind('.//dds:address', NAMESPACE)] == (
            ['127.0.0.1'] if local else [])
        assert [each.text for each in root.iterfind('.//dds:segment_size', NAMESPACE)] == (
            ['67108864'] if captures else [])
        assert [each.text for each in root.iterfind('.//dds:port_queue_capacity', NAMESPACE)] == [
            '2048']
        types = [each.text for each in root.iterfind('.//dds:type', NAMESPACE)]
        assert types == ['SHM', 'UDPv4']
        assert [float(root.findtext(f'.//dds:leaseAnnouncement/dds:{unit}', '', NAMESPACE))
                for unit in ('sec', 'nanosec')] == [0, 5e8]
        # Otherwise Fast DDS adds its own transports, which listen everywhere.
        assert root.findtext('.//dds:useBuiltinTransports', None, NAMESPACE) == 'false'
        used = {each.text for each in root.iterfind('.//dds:userTransports/*', NAMESPACE)}
        assert used == {each.text for each in root.iterfind(
            './/dds:transport_descriptor/dds:transport_id', NAMESPACE)}


@pytest.mark.parametrize(('reach', 'captures', 'file'), [
    ('LOCALHOST', False, 'local.xml'), ('LOCALHOST', True, 'local_transport.xml'),
    ('SUBNET', True, 'transport.xml'), ('SUBNET', False, 'network.xml'),
    (None, False, 'network.xml')])
def test_the_profile_follows_the_range(reach: str | None, captures: bool,
                                       file: str) -> None:
    # Also where a shell still has another of our profiles.
    given = {PROFILE_VARIABLES[0]: str(FOLDER / 'local.xml'), 'HOME': '/'} | (
        {DISCOVERY_RANGE_VARIABLE: reach} if reach else {})
    chosen = with_profile(given, captures)
    assert [chosen.get(name) for name in PROFILE_VARIABLES] == [str(FOLDER / file)] * 2
    assert chosen['HOME'] == '/'


def test_a_users_own_profile_is_left_alone() -> None:
    given = {PROFILE_VARIABLES[1]: '/home/my.xml', DISCOVERY_RANGE_VARIABLE: 'LOCALHOST'}
    assert with_profile(given, captures=True) == given


def offsets(name: str) -> list[str | None]:
    """Return the offsets of the port for messages in the profile of a variable."""
    return [each.text for each in ElementTree.parse(os.environ[name]).getroot().iterfind(
        './/dds:participant/dds:rtps/dds:port/dds:offsetd3', NAMESPACE)]


@pytest.mark.parametrize('profile', PROFILES.values(), ids=lambda profile: profile.name)
def test_each_process_listens_on_a_port_of_its_domain(monkeypatch: pytest.MonkeyPatch,
                                                      profile: Path) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(profile))
    found = set()
    for _ in range(1000):
        with receive_profile(large_messages=True):
            (offset,), others = offsets(PROFILE_VARIABLES[0]), offsets(PROFILE_VARIABLES[1])
            assert others == [offset]
            found.add(int(offset or ''))
            made = Path(os.environ[PROFILE_VARIABLES[0]])
        assert not made.exists()
        assert [os.environ[name] for name in PROFILE_VARIABLES] == [str(profile)] * 2
    # Odd numbers, as those of discovery are even; below 250 also with 32 participants.
    assert found <= set(range(11, 250 - 2 * 31, 2))
    assert len(found) > 80


def test_nobody_removes_the_profile_of_a_process_that_reads_it(
        monkeypatch: pytest.MonkeyPatch) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(FOLDER / 'local.xml'))
    with receive_profile(large_messages=True):
        made = Path(os.environ[PROFILE_VARIABLES[0]])
        clean(made.parent, settled=0.0, among={made.name})
        assert made.exists()


@pytest.mark.parametrize('profile', PROFILES.values(), ids=lambda profile: profile.name)
def test_small_messages_are_heard_by_udp(monkeypatch: pytest.MonkeyPatch, profile: Path) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(profile))
    with receive_profile(large_messages=False):
        rtps = ElementTree.parse(os.environ[PROFILE_VARIABLES[0]]).getroot().find(
            './/dds:participant/dds:rtps', NAMESPACE)
        assert rtps is not None
        assert [each.tag.partition('}')[2] for each in rtps.iterfind(
            'dds:defaultUnicastLocatorList/dds:locator/*', NAMESPACE)] == ['udpv4']
        assert rtps.find('dds:port', NAMESPACE) is None
    assert [os.environ[name] for name in PROFILE_VARIABLES] == [str(profile)] * 2


def test_who_has_no_udp_hears_small_messages_through_shared_memory(
        monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    profile = tmp_path / 'my.xml'
    profile.write_text((FOLDER / 'local.xml').read_text().replace('UDPv4', 'SHM'))
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(profile))
    with receive_profile(large_messages=False):
        assert len(offsets(PROFILE_VARIABLES[0])) == 1


@pytest.mark.parametrize('text', ['<port>', '<defaultUnicastLocatorList>', None,
                                  '\N{DEGREE SIGN}'])
@pytest.mark.parametrize('name', PROFILE_VARIABLES)
def test_a_profile_that_says_where_to_hear_is_left_as_it_is(
        monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str, text: str | None) -> None:
    """A profile that cannot be read stays as it is, too; without a profile none is made."""
    for variable in PROFILE_VARIABLES:
        monkeypatch.delenv(variable, raising=False)
    with receive_profile(large_messages=True):
        assert not any(variable in os.environ for variable in PROFILE_VARIABLES)
    profile = tmp_path / 'my.xml'
    if text is not None:
        profile.write_text(text, encoding='latin-1')
    monkeypatch.setenv(name, str(profile))
    with receive_profile(large_messages=True):
        assert os.environ[name] == str(profile)


def test_without_room_for_a_profile_the_port_is_as_ever(monkeypatch: pytest.MonkeyPatch,
                                                        tmp_path: Path) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(FOLDER / 'local.xml'))
    monkeypatch.setattr(dds_profiles, 'SHARED_MEMORY', tmp_path / 'none')
    with receive_profile(large_messages=True):
        assert os.environ[PROFILE_VARIABLES[0]] == str(FOLDER / 'local.xml')


def test_a_profile_that_cannot_be_written_whole_is_not_used(
        monkeypatch: pytest.MonkeyPatch) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(FOLDER / 'local.xml'))
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    try:
        with receive_profile(large_messages=True):
            assert os.environ[PROFILE_VARIABLES[0]] == str(FOLDER / 'local.xml')
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
