"""``bpc check``: what is there and what is missing, before a print."""

from __future__ import annotations

import atexit
from collections.abc import Iterator
import os
from pathlib import Path
import shutil
import time
from typing import Annotated

import rclpy
from rclpy.executors import SingleThreadedExecutor
import typer

from bpc_perception.claims import domain
from bpc_perception.claims.holder import described
from bpc_perception.cli.parts.options import JsonOption, QuietOption, RemapOption
from bpc_perception.cli.parts.preflight import (
    FAIL,
    Finding,
    judge_calibration,
    judge_design,
    judge_disk,
    judge_domain,
    judge_target,
    judge_transport,
    OK,
)
from bpc_perception.cli.parts.rig_listener import RigListener
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.parameter import ConfigError
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.display.plain_text import one_line
from bpc_perception.display.units import MM_PER_M
from bpc_perception.drivers.cameras import check_back_end
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure, live_recorder, name_other_sections
from bpc_perception.runtime.ros_arguments import remappings
from bpc_perception.runtime.signals import end_in_time
from bpc_perception.runtime.transport.middleware import expect_middleware

S_PER_DAY = 86400.0
SPIN_PERIOD_S = 0.05


def check(
    hand_eye: Annotated[Path, typer.Option(
        '--handeye', metavar='FILE', help='Hand-eye calibration.')],
    parameters: Annotated[Path | None, typer.Option(
        '--params', metavar='FILE', help='ROS parameter file for the nodes.')] = None,
    camera: Annotated[str | None, typer.Option(
        '--camera', metavar='BACK_END', help='live is going to take captures with this back end '
        'of the camera driver, so nobody publishes them yet; unless given, the camera '
        'publishes.')] = None,
    remap: RemapOption = None,
    seconds: Annotated[float, typer.Option(help='How long to listen.')] = 5.0,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Ask before a print what is there; OK, WARN or FAIL for each, and what to do.

    The exit status is 1 if something fails.
    """
    terminal = Terminal(quiet, json_lines)
    others = remappings(remap)
    if camera is not None:
        check_back_end(camera)
    calibration = load_hand_eye(hand_eye)
    age_days = (time.time() - hand_eye.stat().st_mtime) / S_PER_DAY
    findings = [judge_calibration(calibration.on_base, age_days), *settings_findings(parameters),
                *computer_findings()]
    for finding in findings:
        show(finding, terminal)
    recorder = configure(RecorderConfig(), 'path_recorder', parameters)
    name_other_sections(parameters)
    for finding in topic_findings(recorder, others, camera is None, calibration, seconds,
                                  terminal):
        show(finding, terminal)
        findings.append(finding)
    failed = sum(finding.level == FAIL for finding in findings)
    if failed:
        terminal.emit('failed', f'{failed} of {len(findings)} fail', failed=failed,
                      of=len(findings))
        raise typer.Exit(1)


def settings_findings(parameters: Path | None) -> Iterator[Finding]:
    """Yield what is good or bad about parameters."""
    thickness = configure(ThicknessConfig(), 'thickness', parameters)
    advice = thickness.advice
    yield judge_target(advice.target_thickness, advice.target_file)
    if thickness.design.file:
        yield judge_design(thickness.design)
    try:
        offset = live_recorder(parameters).nozzle_offset
    except ConfigError as error:
        yield Finding(FAIL, 'nozzle offset', 'none', str(error))
        return
    yield Finding(OK, 'nozzle offset',
                  ', '.join(f'{value * MM_PER_M:.2f}' for value in offset) + ' mm')


def computer_findings() -> Iterator[Finding]:
    """Yield what is good or bad about this computer: domain, middleware, shared memory, disk."""
    holder = domain.holder()
    yield judge_domain(domain.domain(), '' if holder is None else described(holder))
    shared_memory = shutil.disk_usage('/dev/shm').free  # noqa: S108 (no file is made there)
    yield from judge_transport(os.environ, shared_memory)
    yield judge_disk(str(Path.cwd()), shutil.disk_usage(Path.cwd()).free)


def topic_findings(recorder: RecorderConfig, others: dict[str, str], camera: bool,
                   calibration: HandEye, seconds: float, terminal: Terminal) -> Iterator[Finding]:
    """Listen to the rig for some seconds, then yield what is good or bad about its topics.

    See RigListener for the other arguments.
    """
    expect_middleware()
    # Not the arguments of the command, where := means a remapping, too. It needs no log.
    atexit.register(end_in_time)
    rclpy.init(args=['--ros-args', '--disable-external-lib-logs'])
    node = rclpy.create_node('bpc_check')
    try:
        listener = RigListener(node, recorder, others, camera, calibration)
        executor = SingleThreadedExecutor()  # rclpy.spin_once() is too slow for fast streams
        executor.add_node(node)
        start = time.monotonic()
        with terminal.progress('listen', round(seconds)) as advance:
            while (passed := time.monotonic() - start) < seconds:
                executor.spin_once(timeout_sec=SPIN_PERIOD_S)
                advance(int(passed), round(seconds))
        yield from listener.findings()
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def show(finding: Finding, terminal: Terminal) -> None:
    """Show a finding, with what to do."""
    todo = f'; {finding.todo}' if finding.todo else ''
    words = one_line(f'{finding.subject}: {finding.found}{todo}')
    terminal.emit('finding', f'{finding.level:4} {words}',
                  **finding._asdict())
