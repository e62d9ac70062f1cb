"""Run as a program, tells what the live page costs and how quick it is on a print of 2 m.

200 captures are published, five a second, first with nobody looking and then with one browser:
the processor time of page and browser for a capture, the time from a profile to the screen, and
the longest that the browser drew nothing. Where others use the computer, only the first holds.
"""

from __future__ import annotations

from pathlib import Path
import time

import numpy as np

from bpc_sim.benchmarks.printer import cpu_time
from bpc_system_tests.parts.browser import browsing
from bpc_system_tests.parts.page_stage import Stage, staged
from bpc_system_tests.parts.sample_print import CAPTURES, long_print

PERIOD = 0.2  # [s]
WATCH = """
window.seen = {}; window.longest = 0; let last = performance.now();
const shown = () => document.querySelector('.capture').innerText.split(',')[0];
new MutationObserver(() => { window.seen[shown()] ??= Date.now(); })
  .observe(document.querySelector('.area-top'), {subtree: true, childList: true,
                                                 characterData: true});
(function frame() { const now = performance.now();
  window.longest = Math.max(window.longest, now - last); last = now;
  requestAnimationFrame(frame); })();
"""


def descendants(pid: int) -> list[int]:
    """A process and those that it started, and so on; proc(5), field 4 of stat."""
    found = [pid]
    for file in Path('/proc').glob('[0-9]*/stat'):
        try:
            parent = int(file.read_text().rpartition(')')[2].split()[1])
        except OSError:  # it has ended
            continue
        if parent == pid:
            found += descendants(int(file.parent.name))
    return found


def used(stage: Stage) -> tuple[float, float]:
    """Processor time of the page's process and of the browser's so far [s]."""
    assert stage.driver.service.process is not None
    return (cpu_time(stage.nodes.pid('page')),
            sum(map(cpu_time, descendants(stage.driver.service.process.pid))))


def publish_all(stage: Stage, name: str) -> dict[str, int]:
    """Publish the print, tell what processor time it takes; when each was published [ms]."""
    before = used(stage)
    sent: dict[str, int] = {}
    for capture in range(CAPTURES):
        due = time.monotonic() + PERIOD
        stage.printer.publish(long_print(stage.results[-1], capture))
        sent[f'capture {capture}'] = time.time_ns() // 10**6
        stage.graph.executor.spin_once(timeout_sec=0)
        time.sleep(max(0.0, due - time.monotonic()))
    page, browser = (1e3 * (now - then) / CAPTURES
                     for now, then in zip(used(stage), before, strict=True))
    print(f'{name}: {page:.0f} ms a capture of the page, {browser:.0f} ms of the browser')
    return sent


if __name__ == '__main__':
    with browsing() as driver, staged(driver) as stage:
        publish_all(stage, 'nobody looks')
        stage.open()
        stage.show(4)
        driver.execute_script(WATCH)
        sent = publish_all(stage, 'one browser')
        stage.wait(lambda: stage.text('.capture').startswith(f'capture {CAPTURES - 1},'))
        seen = driver.execute_script('return window.seen')
        if seen is None:
            raise SystemExit('expected one connection all the time, found it lost')
        delays = np.array([seen[name] - at for name, at in sent.items() if name in seen])
        median, high = np.percentile(delays, (50, 95))
        print(f'profile to screen: median {median:.0f} ms, 95 % {high:.0f} ms, '
              f'largest {delays.max():.0f} ms; {len(delays)} of {CAPTURES} were drawn')
        print(f'longest frame: {driver.execute_script("return window.longest"):.0f} ms')
