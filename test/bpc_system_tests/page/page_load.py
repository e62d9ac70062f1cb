"""A program that measures what the live page costs and how fast it is on a print of 2 m.

It publishes 200 captures, five a second: first without a browser, then with one. It prints the
processor time of page and browser per capture, the time from a profile to the screen, and the
longest time in which the browser drew nothing. On a busy computer only processor times are valid.
"""

from __future__ import annotations

import time

import numpy as np

from bpc_sim.benchmarks.process_usage import cpu_time
from bpc_system_tests.parts.browser import browsing
from bpc_system_tests.parts.page_under_test import page_under_test, PageUnderTest
from bpc_system_tests.parts.process_tree import descendants
from bpc_system_tests.parts.sample_print import CAPTURES, long_print

CAPTURE_PERIOD_S = 0.2
WATCH_SCRIPT = """
window.seen = {}; window.longest = 0; let last = performance.now();
const shown = () => document.querySelector('.capture').innerText.split(',')[0];
new MutationObserver(() => { window.seen[shown()] ??= Date.now(); })
  .observe(document.querySelector('.area-top'), {subtree: true, childList: true,
                                                 characterData: true});
(function frame() { const now = performance.now();
  window.longest = Math.max(window.longest, now - last); last = now;
  requestAnimationFrame(frame); })();
"""


def cpu_times(page: PageUnderTest) -> tuple[float, float]:
    """Return the processor time so far of the page's process and of the browser's [s]."""
    assert page.driver.service.process is not None
    browser = page.driver.service.process.pid
    return (cpu_time(page.nodes.pid('page')),
            sum(map(cpu_time, [browser, *descendants([browser])])))


def publish_all(page: PageUnderTest, name: str) -> dict[str, int]:
    """Publish the print and print the processor time; return when each was published [ms]."""
    before = cpu_times(page)
    sent: dict[str, int] = {}
    for capture in range(CAPTURES):
        due = time.monotonic() + CAPTURE_PERIOD_S
        page.printer.publish(long_print(page.results[-1], capture))
        sent[f'capture {capture}'] = time.time_ns() // 10**6
        page.graph.executor.spin_once(timeout_sec=0)
        time.sleep(max(0.0, due - time.monotonic()))
    page_ms, browser_ms = (1e3 * (now - then) / CAPTURES
                           for now, then in zip(cpu_times(page), before, strict=True))
    print(f'{name}: {page_ms:.0f} ms a capture of the page, {browser_ms:.0f} ms of the browser')
    return sent


def main() -> None:
    """Publish the print twice, and print the figures."""
    with browsing() as driver, page_under_test(driver) as page:
        publish_all(page, 'nobody looks')
        page.open()
        page.show(4)
        driver.execute_script(WATCH_SCRIPT)
        sent = publish_all(page, 'one browser')
        page.wait(lambda: page.text('.capture').startswith(f'capture {CAPTURES - 1},'))
        seen = driver.execute_script('return window.seen')
        if seen is None:
            raise SystemExit('expected one connection all the time, found it lost')
        delays = np.array([seen[name] - at for name, at in sent.items() if name in seen])
        median, high = np.percentile(delays, (50, 95))
        print(f'profile to screen: median {median:.0f} ms, 95 % {high:.0f} ms, '
              f'largest {delays.max():.0f} ms; {len(delays)} of {CAPTURES} were drawn')
        print(f'longest frame: {driver.execute_script("return window.longest"):.0f} ms')


if __name__ == '__main__':
    main()
