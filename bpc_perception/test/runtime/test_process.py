"""Memory, signs of life and end of the processes of nodes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')
pytestmark = pytest.mark.ros

GIVE_WAY = """
import os, threading
import bpc_perception.nodes
import cv2
from bpc_perception.core.config import ProcessConfig
from bpc_perception.runtime.process import limit_cpu_use
from rclpy.logging import get_logger

stop = threading.Event()
other = threading.Thread(target=stop.wait)
other.start()  # the middleware has threads before a node knows its parameters
try:
    limit_cpu_use(ProcessConfig(threads=2, niceness=7), get_logger('test'))
    threads = [int(thread) for thread in os.listdir('/proc/self/task')]
    nice = {os.getpriority(os.PRIO_PROCESS, thread) for thread in threads}
finally:
    stop.set()
assert nice == {7}, nice
assert cv2.getNumThreads() == 2
assert os.environ['OPENBLAS_NUM_THREADS'] == '1'
"""
REFUSED = """
import os
from bpc_perception.core.config import ProcessConfig
from bpc_perception.runtime import process

def refuse(*_):
    raise PermissionError('not permitted')

class Logger:
    def warning(self, text):
        print(text)

os.setpriority = refuse
process.limit_cpu_use(ProcessConfig(niceness=-5), Logger())
"""
KEEP = """
import resource
from bpc_perception.runtime.process import keep_memory
keep_memory()
import numpy as np

def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    np.ones(10_000_000)  # 80 MB, more than glibc keeps by itself
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

first, second = faults(), faults()
assert second < first / 10, (first, second)
"""
PARENT = """
import os, subprocess, sys
child = "import os, sys, time; from bpc_perception.runtime.process import end_with_parent; " \\
        "end_with_parent(); print(os.getpid(), file=sys.stderr, flush=True); time.sleep(60)"
started = subprocess.Popen([sys.executable, '-c', child], stderr=subprocess.PIPE,
                           env={**os.environ, 'BPC_PARENT': str(os.getpid())})
assert int(started.stderr.readline()) == started.pid
print('ready', flush=True)
os.kill(os.getpid(), 9)
"""
ORPHAN = """
from bpc_perception.runtime.process import end_with_parent
end_with_parent()
print('still there')
"""


def run(script: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, '-c', script], capture_output=True, text=True,
                          timeout=60, check=False, env={**os.environ, **environment})


@pytest.mark.parametrize('script', [GIVE_WAY, KEEP], ids=['give way', 'keep memory'])
def test_in_a_process_of_its_own(script: str) -> None:
    ended = run(script)
    assert ended.returncode == 0, ended.stderr


def test_what_is_not_allowed_is_said() -> None:
    ended = run(REFUSED)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout == ('process.niceness: expected to be allowed -5, found: not permitted; '
                            f'running with {os.getpriority(os.PRIO_PROCESS, 0)}\n')


def test_a_child_ends_when_its_parent_is_killed() -> None:
    # Both write to the same pipe: its end is reached when both have ended.
    ended = run(PARENT)
    assert (ended.returncode, ended.stdout) == (-signal.SIGKILL, 'ready\n'), ended.stderr


def test_who_lost_its_parent_before_ends_at_once() -> None:
    ended = run(ORPHAN, BPC_PARENT='1')
    assert (ended.returncode, ended.stdout) == (1, '')


# Its output stays open as long as the child lives.
HANGING = """
import os, subprocess, sys
child = "import signal, time; from bpc_perception.runtime.process import end_with_parent; " \\
        "signal.signal(signal.SIGTERM, signal.SIG_IGN); end_with_parent(); " \\
        "print('ready', flush=True); time.sleep(60)"
started = subprocess.Popen([sys.executable, '-c', child], stdout=sys.stdout,
                           env={**os.environ, 'BPC_PARENT': str(os.getpid())})
sys.stdin.readline()
os.kill(os.getpid(), 9)
"""


def test_who_hangs_in_ending_ends_all_the_same() -> None:
    with subprocess.Popen([sys.executable, '-c', HANGING], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == 'ready\n'
        out, _ = parent.communicate('end\n', timeout=30)  # until the child has closed it as well
    assert (parent.returncode, out) == (-signal.SIGKILL, '')
