"""Run as a program, tells how smoothly page and report of a print of 2 m scroll.

A wheel is turned down to the end and up again while the browser is asked when it draws. The page
gets five captures a second meanwhile; the report's slider is moved besides. The browser has no
graphics card, so that all of it is drawn by the processor.
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
from bpc_system_tests.parts.browser import browsing, DESKTOP, PHONE, show_as
from bpc_system_tests.parts.command_line import SAMPLE
from bpc_system_tests.parts.page_stage import Stage, staged
from bpc_system_tests.parts.sample_print import CAPTURES, enlarged, long_print, sample_results

NOTCH, STEP_TIME = 100, 1 / 30  # of the wheel [pixels], between two of them [s]
PERIOD = 0.2  # of captures [s]
LARGER = 6  # makes 1824 x 1368 pixels of the sample print's captures
WATCH = """
window.frames_drawn = []; let last = performance.now();
(function frame() { const now = performance.now(); window.frames_drawn.push(now - last);
  last = now; requestAnimationFrame(frame); })();
"""


def roll(driver: Chrome) -> None:
    """Turn the wheel from the top to the end and back."""
    height = int(driver.execute_script('return document.documentElement.scrollHeight'))
    for direction in (1, -1):
        for _ in range(height // NOTCH + 1):
            driver.execute_cdp_cmd('Input.dispatchMouseEvent', {
                'type': 'mouseWheel', 'x': 20, 'y': 300, 'deltaX': 0,
                'deltaY': direction * NOTCH})
            time.sleep(STEP_TIME)
    assert int(driver.execute_script('return window.scrollY')) == 0


def slide(driver: Chrome) -> None:
    """Move the slider through the captures."""
    for number in np.linspace(0, CAPTURES - 1, 40).astype(int).tolist():
        driver.execute_script(
            'const slider = document.querySelector("input[type=range]");'
            'slider.value = arguments[0];'
            'slider.dispatchEvent(new Event("input", {bubbles: true}));', number)
        time.sleep(STEP_TIME)


def watch(driver: Chrome, name: str, act: Callable[[Chrome], None]) -> None:
    """Tell how long frames took while something was done."""
    driver.execute_script(WATCH)
    act(driver)
    frames = np.array(driver.execute_script('return window.frames_drawn')[1:])
    median, high = np.percentile(frames, (50, 95))
    print(f'{name}: {len(frames)} frames, median {median:.0f} ms, 95 % {high:.0f} ms, '
          f'longest {frames.max():.0f} ms, over 100 ms {np.mean(frames > 100):.1%}', flush=True)


def report(driver: Chrome) -> None:
    """A report of all captures."""
    last = enlarged(sample_results()[-1], LARGER)
    log = PrintLog(expected=CAPTURES)
    for capture in range(CAPTURES):
        log.add(long_print(last, capture))
    with tempfile.TemporaryDirectory() as folder:
        write_outputs(Path(folder), log, load(SAMPLE, None, None).provenance)
        file = Path(folder, 'report.html')
        print(f'report: {file.stat().st_size / 1e6:.2f} MB')
        for name, size in (('desktop', DESKTOP), ('phone', PHONE)):
            show_as(driver, size)
            driver.get(file.as_uri())
            time.sleep(3)  # until all is drawn
            watch(driver, f'report, {name}', roll)
        watch(driver, 'report, slider', slide)


@contextmanager
def printing(stage: Stage) -> Iterator[None]:
    """The end of the long print comes in, capture after capture."""
    done = Event()

    def publish() -> None:
        capture = CAPTURES // 2
        while not done.wait(PERIOD):
            capture = min(capture + 1, CAPTURES - 1)
            stage.printer.publish(long_print(stage.results[-1], capture))

    thread = Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def page(driver: Chrome) -> None:
    """The live page while the print goes on."""
    for name, size in (('desktop', DESKTOP), ('phone', PHONE)):
        show_as(driver, size)
        with staged(driver) as stage:
            stage.open()
            stage.show(4)
            with printing(stage):
                watch(driver, f'page, {name}', roll)


if __name__ == '__main__':
    with browsing() as driver:
        report(driver)
        page(driver)
