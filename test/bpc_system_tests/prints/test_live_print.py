"""A print on the synthetic printer, measured while it runs: every node is a process."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
import re
import time

import numpy as np
import pytest

from bpc_interfaces.msg import RateAdvice, ThicknessProfile
from bpc_perception.core.profile import run_extents
from bpc_perception.messages import topics
from bpc_perception.messages.profile import profile_from_message
from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.runtime.child_processes import Nodes
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_sim.printer.settings import write_settings
from bpc_system_tests.parts.command_line import ROOT
from bpc_system_tests.parts.print_comparison import compare, expect_the_truth, pixel_size
from bpc_system_tests.parts.ros_graph import Listener, listening, own_domain, start_delay

pytestmark = [pytest.mark.system, pytest.mark.ros]

SCENARIO, SPEED_M_PER_S = 'spiral_gaps', 0.03  # 174 mm in 6 s
TARGET_M = 2e-3
CAMERA_RATE_HZ = 2.0
JOB = SCENARIOS[SCENARIO](SPEED_M_PER_S)


@dataclass(frozen=True)
class LivePrint:
    """The messages heard during a print.

    Attributes:
        start_ns, end_ns: start and end of the job, by the clock of the nodes [ns].
        order: topics of all messages, in the order of arrival.
        profiles, advice: messages up to a capture of the complete print.
        published: names of all published topics.
        complaints: of the thickness node.
        late_profiles: profiles of a thickness node that was started after the print.
    """

    start_ns: int
    end_ns: int
    order: list[str]
    profiles: list[ThicknessProfile]
    advice: list[RateAdvice]
    published: set[str]
    complaints: list[str]
    late_profiles: list[ThicknessProfile]


@pytest.fixture(scope='module')
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LivePrint]:
    folder = tmp_path_factory.mktemp('live')
    settings = write_settings(JOB, TARGET_M, folder)
    with (own_domain() as domain, listening(domain) as listener,
          Nodes(settings.parameters) as nodes):
        with Nodes(settings.parameters) as measuring:
            start_ns, end_ns = start_print(listener, nodes, measuring, settings.hand_eye)
            listener.wait(lambda: any(stamp(profile) > end_ns for profile in listener.profiles)
                          and len(listener.advice) == len(listener.profiles), nodes)
            measuring.check()
            published = {name for name, _ in listener.node.get_topic_names_and_types()
                         if listener.node.count_publishers(name)}
        order, profiles = listener.order.copy(), listener.profiles.copy()
        complaints = listener.complaints('thickness')
        with Nodes(settings.parameters) as measuring:
            measuring.start('bpc_perception.nodes.thickness',
                            hand_eye_file=str(settings.hand_eye))
            listener.wait(lambda: len(listener.profiles) > len(profiles), nodes)
            measuring.check()
        yield LivePrint(start_ns, end_ns, order, profiles, listener.advice[:len(profiles)],
                        published, complaints, listener.profiles[len(profiles):])


def start_print(listener: Listener, nodes: Nodes, measuring: Nodes,
                calibration: Path) -> tuple[int, int]:
    """Start a print and the nodes that measure it; return when it starts and ends [ns]."""
    begun = time.monotonic()
    measuring.start('bpc_perception.nodes.thickness', hand_eye_file=str(calibration))
    nodes.start('bpc_perception.nodes.path_recorder')
    names = {'thickness', 'path_recorder'}
    listener.wait(lambda: names <= set(listener.node.get_node_names()), nodes)
    start_ns = time.time_ns() + round(start_delay(time.monotonic() - begun) * 1e9)
    job = {'scenario': SCENARIO, 'speed': SPEED_M_PER_S, 'start_time_ns': start_ns}
    nodes.start('bpc_sim.nodes.robot', **job)
    nodes.start('bpc_sim.nodes.extruder', **job)
    nodes.start('bpc_perception.nodes.camera_driver', back_end='synthetic', rate=CAMERA_RATE_HZ,
                **job)
    # A node is known by name before its publishers are: the first profile would be missed.
    results = {topics.PROFILE, topics.ADVICE}
    listener.wait(lambda: all(listener.node.count_publishers(name)
                              for name in topics.PRINT.keys() | topics.CAMERA | results), nodes)
    assert time.time_ns() < start_ns, 'the machine has become slower meanwhile'
    return start_ns, start_ns + round(JOB.duration * 1e9)


def stamp(message: ThicknessProfile | RateAdvice) -> int:
    return stamp_to_ns(message.header.stamp)


def test_profile_grows_with_each_capture(live: LivePrint) -> None:
    profiles = live.profiles
    # Captures while ink flows and the nozzle is on the bed, and one of the complete print.
    assert len(profiles) >= 5
    assert [profile.capture for profile in profiles] == list(range(len(profiles))), (
        live.complaints)
    assert len({profile.print_id for profile in profiles}) == 1
    stamps = [stamp(profile) for profile in profiles]
    assert stamps == sorted(set(stamps))
    printing = [profile for profile in profiles if stamp(profile) < live.end_ns - 2e9]
    reach = [profile.arc_length[-1] for profile in printing]
    assert len(printing) >= 4
    assert (np.diff(reach) > 0).all()
    # The path reaches as far as the nozzle at the stamp, less the poses that smoothing waits for.
    laid = JOB.laid((np.array([stamp(each) for each in printing]) - live.start_ns) * 1e-9)
    assert reach == pytest.approx(laid, abs=0.15 * SPEED_M_PER_S)


@pytest.mark.parametrize(('file', 'frame'), [
    ('rviz/bpc.rviz', r'Fixed Frame: (\w+)'), ('foxglove/bpc.json', r'"followTf": "(\w+)"')])
def test_what_layouts_look_at_is_there(live: LivePrint, file: str, frame: str) -> None:
    text = (ROOT / 'bpc_perception' / file).read_text(encoding='utf-8')
    named = set(re.findall(r'(?:Value: |": ?"|")(/[a-z][a-z_/]*)\b', text))
    assert f'/{topics.MARKERS}' in named
    assert named <= live.published
    assert set(re.findall(frame, text)) == {live.profiles[-1].header.frame_id}


def test_advice_follows_each_profile(live: LivePrint) -> None:
    assert [stamp(advice) for advice in live.advice] == [stamp(each) for each in live.profiles]
    results = [name for name in live.order if name in (topics.PROFILE, topics.ADVICE)]
    assert results == [topics.PROFILE, topics.ADVICE] * len(live.profiles)
    for advice, profile in zip(live.advice, live.profiles, strict=True):
        assert advice.print_id == profile.print_id
        assert advice.target_thickness == TARGET_M
        assert stamp_to_ns(advice.valid_until) > stamp(advice)
        assert advice.window_end <= profile.arc_length[-1]
    valid = [advice for advice in live.advice if advice.valid]
    assert valid
    for advice in valid:
        # More ink or less speed where the bead is too thin; the opposite where it is too thick.
        thin = TARGET_M - advice.expected_thickness
        assert (advice.flow_rate_scale - 1) * thin >= 0
        assert (advice.flow_rate_scale - 1) * (advice.speed_scale - 1) <= 0
        assert advice.flow_rate == pytest.approx(
            advice.flow_rate_scale * np.pi / 4 * TARGET_M**2 * SPEED_M_PER_S)


@pytest.mark.accuracy
def test_final_profile_is_the_truth(live: LivePrint) -> None:
    compared = compare(profile_from_message(live.profiles[-1]), JOB)
    assert compared.s.min() < 1e-3
    assert compared.s.max() > JOB.length - 1e-3
    expect_the_truth(compared, pixel_size(JOB))


@pytest.mark.accuracy
def test_every_gap_is_found(live: LivePrint) -> None:
    compared = compare(profile_from_message(live.profiles[-1]), JOB)
    wanted = np.array(sorted(JOB.commanded.gaps.tolist() + JOB.faults.tolist()))
    assert run_extents(compared.bare, compared.s) == pytest.approx(wanted, abs=0.6e-3)
    assert run_extents(compared.profile.missing, compared.s) == pytest.approx(
        JOB.faults, abs=0.6e-3)
    # The extruder runs through the fault in the middle, and pauses in the planned gaps.
    extruding = [compared.profile.extruding[(compared.s > start) & (compared.s < end)].mean()
                 for start, end in wanted]
    assert [share > 0.5 for share in extruding] == [False, True, False]


@pytest.mark.accuracy
def test_node_started_late_measures_the_same_print(live: LivePrint) -> None:
    last, late = live.profiles[-1], live.late_profiles[0]
    assert late.print_id == last.print_id
    assert late.arc_length[:len(last.arc_length)] == last.arc_length
    # The node counts anew; its first profile may come before the listener has found it.
    assert late.capture < last.capture
    expect_the_truth(compare(profile_from_message(late), JOB), pixel_size(JOB))
