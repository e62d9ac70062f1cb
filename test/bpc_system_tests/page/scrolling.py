"""A program that measures how smoothly page and report of a print of 2 m scroll.

It turns a mouse wheel down to the end and up again, and records when the browser draws. Meanwhile
the page gets five captures a second; in the report the slider is moved, too. The browser has no
graphics card, so the processor draws everything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
import tempfile
from threading import Event, Thread
import time

import numpy as np
from selenium.webdriver import Chrome

from bpc_perception.recording.inputs import load
from bpc_perception.report.outputs import write_outputs
from bpc_perception.report.print_log import PrintLog
from bpc_system_tests.parts.browser import browsing, DESKTOP_PX, PHONE_PX, show_as
from bpc_system_tests.parts.command_line import SAMPLE
from bpc_system_tests.parts.page_under_test import page_under_test, PageUnderTest
from bpc_system_tests.parts.sample_print import CAPTURES, enlarged, long_print, sample_results

WHEEL_STEP_PX = 100
STEP_PERIOD_S = 1 / 30  # between two steps of wheel or slider
CAPTURE_PERIOD_S = 0.2
ENLARGEMENT = 6  # makes 1824 x 1368 pixels of the sample print's captures
DRAWING_TIME_S = 3  # until all of a report is drawn
SLOW_FRAME_MS = 100
WATCH_SCRIPT = """
window.frames_drawn = []; let last = performance.now();
(function frame() { const now = performance.now(); window.frames_drawn.push(now - last);
  last = now; requestAnimationFrame(frame); })();
"""


def roll(driver: Chrome) -> None:
    """Turn the wheel from the top to the end and back."""
    height = int(driver.execute_script('return document.documentElement.scrollHeight'))
    for direction in (1, -1):
        for _ in range(height // WHEEL_STEP_PX + 1):
            driver.execute_cdp_cmd('Input.dispatchMouseEvent', {
                'type': 'mouseWheel', 'x': 20, 'y': 300, 'deltaX': 0,
                'deltaY': direction * WHEEL_STEP_PX})
            time.sleep(STEP_PERIOD_S)
    assert int(driver.execute_script('return window.scrollY')) == 0


def slide(driver: Chrome) -> None:
    """Move the slider through the captures."""
    for number in np.linspace(0, CAPTURES - 1, 40).astype(int).tolist():
        driver.execute_script(
            'const slider = document.querySelector("input[type=range]");'
            'slider.value = arguments[0];'
            'slider.dispatchEvent(new Event("input", {bubbles: true}));', number)
        time.sleep(STEP_PERIOD_S)


def watch(driver: Chrome, name: str, act: Callable[[Chrome], None]) -> None:
    """Do something, and print how long the browser's frames took."""
    driver.execute_script(WATCH_SCRIPT)
    act(driver)
    frames = np.array(driver.execute_script('return window.frames_drawn')[1:])
    median, high = np.percentile(frames, (50, 95))
    print(f'{name}: {len(frames)} frames, median {median:.0f} ms, 95 % {high:.0f} ms, '
          f'longest {frames.max():.0f} ms, '
          f'over {SLOW_FRAME_MS} ms {np.mean(frames > SLOW_FRAME_MS):.1%}', flush=True)


def measure_report(driver: Chrome) -> None:
    """Measure a report of all captures."""
    last = enlarged(sample_results()[-1], ENLARGEMENT)
    log = PrintLog(expected=CAPTURES)
    for capture in range(CAPTURES):
        log.add(long_print(last, capture))
    with tempfile.TemporaryDirectory() as folder:
        write_outputs(Path(folder), log, load(SAMPLE, None, None).provenance)
        file = Path(folder, 'report.html')
        print(f'report: {file.stat().st_size / 1e6:.2f} MB')
        for name, size in (('desktop', DESKTOP_PX), ('phone', PHONE_PX)):
            show_as(driver, size)
            driver.get(file.as_uri())
            time.sleep(DRAWING_TIME_S)
            watch(driver, f'report, {name}', roll)
        watch(driver, 'report, slider', slide)


@contextmanager
def publishing(page: PageUnderTest) -> Iterator[None]:
    """Publish the second half of the long print during the block, capture after capture."""
    done = Event()

    def publish() -> None:
        capture = CAPTURES // 2
        while not done.wait(CAPTURE_PERIOD_S):
            capture = min(capture + 1, CAPTURES - 1)
            page.printer.publish(long_print(page.results[-1], capture))

    thread = Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def measure_page(driver: Chrome) -> None:
    """Measure the live page while the print goes on."""
    for name, size in (('desktop', DESKTOP_PX), ('phone', PHONE_PX)):
        show_as(driver, size)
        with page_under_test(driver) as page:
            page.open()
            page.show(4)
            with publishing(page):
                watch(driver, f'page, {name}', roll)


if __name__ == '__main__':
    with browsing() as driver:
        measure_report(driver)
        measure_page(driver)
