"""Kills set-ups at random moments, half of them beside a print, and starts the next.

``python -m bpc_system_tests.robustness.killed_setup --kills 200 --seed 1``: a checkout with the
set-up itself and a lock of one small wheel; Python's venv and pip are real, colcon and the
product are stand-ins. Before each kill the lock, the messages or the Python change. The print
loads modules and starts children of its environment when told to, amid the set-up and after it.
"""

from __future__ import annotations

import argparse
from collections import Counter
import hashlib
import os
from pathlib import Path
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile

from bpc_system_tests.parts.command_line import ROOT

LONGEST_S = 12.0  # of a set-up of the small checkout, on a busy machine
BUILD_SHARE = 0.3  # of it for the messages alone
PATIENCE_S = 120.0
DAY_S = 86400.0
MODULES = 40  # of environment and build each, which a print loads one after the other
# Each way to end a set-up: the signal, and whether the whole process group gets it.
ENDS = ((signal.SIGKILL, False), (signal.SIGKILL, True), (signal.SIGTERM, False),
        (signal.SIGINT, True))

# A build in steps, of a process and a child that goes on when only its parent is killed.
COLCON = """
import pathlib, subprocess, sys, time
build, install = (pathlib.Path(word.partition('=')[2]) for word in sys.argv[2:4]) \\
    if len(sys.argv) > 3 else (pathlib.Path('build'), pathlib.Path('install'))
site = install / 'lib' / f'python3.{sys.version_info.minor}' / 'site-packages' / 'bpc_interfaces'
for package in ('bpc_perception', 'bpc_sim'):
    (build / package).mkdir(parents=True, exist_ok=True)
(site / 'msg').mkdir(parents=True, exist_ok=True)
text = pathlib.Path('bpc_interfaces/msg/A.msg').read_text()
write = '''
import pathlib, sys, time
for name in ['__init__', *(f'm{number}' for number in range(%d))]:
    (pathlib.Path(sys.argv[1]) / f'{name}.py').write_text(f'TEXT = {sys.argv[2]!r}')
    time.sleep(0.05)
''' % MODULES
(site / '__init__.py').touch()
sys.exit(subprocess.call([sys.executable, '-c', write, str(site / 'msg'), text]))
""".replace('MODULES', str(MODULES))

# Answers each line that it reads, if its own modules still fit those that it began with.
PRODUCT = f"""
import importlib, subprocess, sys
import bpc_interfaces.msg, rclpy
if 'print' in sys.argv:
    child = ('import sys, rclpy, bpc_interfaces.msg.m1; '
             'print(rclpy.TEXT == sys.argv[1] and bpc_interfaces.msg.m1.TEXT == sys.argv[2])')
    print('prints', flush=True)
    for number, _ in enumerate(sys.stdin):
        late = [importlib.import_module(f'{{package}}.m{{number % {MODULES}}}').TEXT
                for package in ('rclpy', 'bpc_interfaces.msg')]
        assert late == [rclpy.TEXT, bpc_interfaces.msg.TEXT], late
        assert subprocess.check_output([sys.executable, '-c', child, *late]) == b'True\\n'
        print('goes on', flush=True)
"""


def wheel(folder: Path, text: str) -> Path:
    """Write a wheel with stand-ins for rclpy, NumPy and colcon."""
    files = {f'rclpy/m{number}.py': f'TEXT = {text!r}' for number in range(MODULES)} | {
        'rclpy/__init__.py': f'TEXT = {text!r}', 'colcon.py': COLCON,
        'numpy.py': 'def get_include(): return "include"',
        'small-1.dist-info/METADATA': 'Metadata-Version: 2.1\nName: small\nVersion: 1\n',
        'small-1.dist-info/WHEEL': (
            'Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n')}
    path = folder / f'{hashlib.sha256(text.encode()).hexdigest()[:8]}/small-1-py3-none-any.whl'
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, 'w') as archive:
        for name, content in files.items():
            archive.writestr(name, content)
        archive.writestr('small-1.dist-info/RECORD', ''.join(f'{name},,\n' for name in files))
    return path


class Checkout:
    """A small checkout, and the starts of its ``./bpc``."""

    def __init__(self, root: Path, source: Path) -> None:
        """Copy the set-up of a checkout, and make the rest."""
        self.root = root
        shutil.copy(source / 'bpc', root)
        shutil.copytree(source / 'bootstrap', root / 'bootstrap',
                        ignore=shutil.ignore_patterns('*.lock', '__pycache__'))
        self.message = root / 'bpc_interfaces' / 'msg' / 'A.msg'
        product = root / 'bpc_perception' / 'bpc_perception'
        for folder in (self.message.parent, product, root / 'bpc_sim', root / 'test'):
            folder.mkdir(parents=True)
        (product / '__main__.py').write_text(PRODUCT)
        self.environment = {
            key: value for key, value in os.environ.items()
            if not key.startswith(('BPC_', '_ROS', 'PYTHON', 'VIRTUAL'))}

    def change_lock(self, text: str) -> None:
        """Write a lock of other content."""
        path = wheel(self.root / 'wheels', text)
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        (self.root / 'bootstrap' / 'requirements.lock').write_text(
            f'small @ file://{path} --hash=sha256:{digest}\n')

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        """Start ``./bpc`` in a process group of its own."""
        return subprocess.Popen(
            [sys.executable, self.root / 'bpc', *arguments], env=self.environment, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            start_new_session=True)

    def pass_a_day(self) -> None:
        """Make the last starts so old that only what runs keeps its environment."""
        for file in self.root.glob('.environments/*/in-use'):
            os.utime(file, (time.time() - 2 * DAY_S,) * 2)

    def left(self) -> int:
        """Return how many environments and builds there are."""
        return len(list(self.root.glob('.environments/*/in-use')))


def goes_on(printing: subprocess.Popen[str]) -> bool:
    """Let a print load modules and start a child; tell whether it could."""
    assert printing.stdin
    assert printing.stdout
    try:
        printing.stdin.write('\n')
        printing.stdin.flush()
    except OSError:
        return False
    return printing.stdout.readline() == 'goes on\n'


def killed(checkout: Checkout, chance: random.Random, printing: subprocess.Popen[str] | None,
           longest: float) -> tuple[bool, list[str]]:
    """Kill one set-up, unless it is done before, and start the next.

    Return whether it was killed, and what went wrong.
    """
    faults = []
    checkout.pass_a_day()
    setting_up = checkout.start('--help')
    try:
        setting_up.wait(timeout=chance.uniform(0, longest))
        done = True
    except subprocess.TimeoutExpired:
        done = False
        if printing and not goes_on(printing):
            faults.append('the print ended during the set-up')
        order, group = chance.choice(ENDS)
        (os.killpg if group else os.kill)(setting_up.pid, order)
    following = checkout.start('--help')
    _, complaints = following.communicate(timeout=PATIENCE_S)
    if following.returncode:
        faults.append(f'the next start: {complaints[-300:]}')
    setting_up.communicate(timeout=PATIENCE_S)
    if printing and not faults and not goes_on(printing):
        faults.append('the print ended after the set-up')
    return not done, faults


def trial(checkout: Checkout, number: int, chance: random.Random, pythons: list[str],
          longest: float) -> tuple[bool, list[str]]:
    """Change something, set up beside a print or beside none, and kill that.

    Return whether it was killed, and what went wrong.
    """
    printing = checkout.start('print') if number % 2 else None
    if printing and printing.stdout and printing.stdout.readline() != 'prints\n':
        return False, ['no print began']
    what = chance.choice(('lock', 'messages', 'python'))
    if what == 'lock':
        checkout.change_lock(f'lock {number}')
    elif what == 'messages':
        checkout.message.write_text(f'message {number}')
        longest *= BUILD_SHARE
    else:
        others = [python for python in pythons if python != checkout.environment['BPC_PYTHON']]
        checkout.environment['BPC_PYTHON'] = chance.choice(others or pythons)
    was_killed, faults = killed(checkout, chance, printing, longest)
    if printing:
        printing.communicate(timeout=PATIENCE_S)
    checkout.pass_a_day()
    last = checkout.start('--help')
    last.communicate(timeout=PATIENCE_S)
    if last.returncode or checkout.left() > 2:
        faults.append(f'{checkout.left()} environments and builds stay, expected 2')
    return was_killed, [f'{what}: {fault}' for fault in faults]


def main() -> int:
    """Run the trials, and print what went wrong."""
    parser = argparse.ArgumentParser(description=__doc__.partition('\n')[0])
    parser.add_argument('--kills', type=int, default=20)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--longest', type=float, default=LONGEST_S, help='latest kill [s]')
    parser.add_argument('--pythons', nargs='+', default=[sys.executable])
    parser.add_argument('--source', type=Path, default=ROOT, help='the checkout with the set-up')
    given = parser.parse_args()
    chance, counts = random.Random(given.seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        checkout = Checkout(Path(folder).resolve(), given.source)
        checkout.change_lock('first')
        checkout.message.write_text('first')
        checkout.environment['BPC_PYTHON'] = given.pythons[0]
        _, complaints = checkout.start('--help').communicate()
        print(complaints)
        for number in range(given.kills):
            was_killed, faults = trial(checkout, number, chance, given.pythons, given.longest)
            counts['faults'] += bool(faults)
            counts['killed'] += was_killed
            counts['beside a print'] += was_killed and number % 2
            print(f'{number + 1}: {faults or "good"}, so far {dict(counts)}', flush=True)
    return int(counts['faults'] > 0)


if __name__ == '__main__':
    sys.exit(main())
