"""Run as a program, makes the pictures of the documentation anew.

They are overlay.png, page.jpg, report.jpg and control.jpg in docs/pictures, and of the tutorial of
a new ink sweep.png, window.jpg and good_print.jpg. JPEGs need a browser.
"""

from __future__ import annotations

from pathlib import Path
import tempfile

import cv2
import numpy as np
from selenium.webdriver import Chrome

from bpc_perception.core.result import Result
from bpc_perception.display.overlay import draw_overlay
from bpc_system_tests.documentation.walk import NEW_INK, walk
from bpc_system_tests.parts.archive import record_archive, STEADY
from bpc_system_tests.parts.browser import browsing, DESKTOP_PX, missing, show_as
from bpc_system_tests.parts.command_line import ROOT, SAMPLE, succeed
from bpc_system_tests.parts.page_under_test import page_under_test, PageUnderTest
from bpc_system_tests.parts.sample_print import sample_results

PICTURES = ROOT / 'docs' / 'pictures'
LARGEST = 200_000  # [bytes]
QUALITIES = range(95, 40, -5)  # of JPEG
WIDE_PX = (1400, 780)
# Names of files as one sees them who works in that folder.
HIDE_FOLDER = """for (const words of document.querySelectorAll("p"))
    words.innerHTML = words.innerHTML.replaceAll(arguments[0], "")"""
NODES = ('camera_driver', 'path_recorder', 'thickness')


def overlay(result: Result, name: str) -> None:
    """A capture with its side points."""
    picture = draw_overlay(result) & 0xF0  # fewer colours, a smaller file
    cv2.imwrite(str(PICTURES / name), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR),
                [cv2.IMWRITE_PNG_COMPRESSION, 9])


def page(stage: PageUnderTest) -> None:
    """The live page after that capture."""
    stage.open()
    for capture in range(1, len(stage.results)):
        stage.show(capture)
    for name in NODES:
        stage.printer.say(name)
    stage.wait(lambda: stage.text('.area-nodes').count('ok') == len(NODES))
    stage.wait(lambda: stage.driver.execute_script(
        'const image = document.querySelector(".overlay img"); return image?.complete'))
    height = int(stage.driver.execute_script('return document.body.scrollHeight'))
    show_as(stage.driver, (DESKTOP_PX[0], height))
    stage.wait(lambda: stage.driver.execute_script(
        'return document.querySelector(".chart canvas").width > 1000'))
    save(stage.driver, 'page.jpg')


def report(driver: Chrome) -> None:
    """The top of the sample print's report."""
    with tempfile.TemporaryDirectory() as folder:
        succeed('measure', SAMPLE.relative_to(ROOT), '--out', folder, folder=ROOT)
        show_as(driver, DESKTOP_PX)
        driver.get(Path(folder, 'report.html').as_uri())
        save(driver, 'report.jpg')


def control(driver: Chrome) -> None:
    """The control chart of an archive whose last prints get thinner."""
    with tempfile.TemporaryDirectory() as folder:
        archive, results = Path(folder, 'archive'), Path(folder, 'results')
        record_archive(archive)
        succeed('batch', archive, '--out', results, '--baseline', STEADY)
        show_as(driver, DESKTOP_PX)
        driver.get((results / 'prints.html').as_uri())
        driver.execute_script('document.querySelector("h3").scrollIntoView()')
        save(driver, 'control.jpg')


def new_ink(driver: Chrome) -> None:
    """The sweep of a new ink, its window, and the report of the print with the settings found."""
    with tempfile.TemporaryDirectory() as folder:
        walk(NEW_INK, Path(folder))
        there = Path(folder, 'ink_7')
        overlay(sample_results(there / 'sweep')[-1], 'sweep.png')
        show_as(driver, WIDE_PX)
        for page_of, name in (('window/window.html', 'window.jpg'),
                              ('results/report.html', 'good_print.jpg')):
            driver.get((there / page_of).as_uri())
            driver.execute_script(HIDE_FOLDER, f'{folder}/')
            save(driver, name)


def save(driver: Chrome, name: str) -> None:
    """What the browser shows, as good as it gets in a small file."""
    picture = cv2.imdecode(np.frombuffer(driver.get_screenshot_as_png(), np.uint8),
                           cv2.IMREAD_COLOR)
    for quality in QUALITIES:
        _, data = cv2.imencode('.jpg', picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
        if len(data) < LARGEST:
            (PICTURES / name).write_bytes(data.tobytes())
            return
    raise ValueError(f'{name}: expected less than {LARGEST} bytes, found {len(data)}')


if __name__ == '__main__':
    if lacking := missing():
        raise SystemExit(lacking)
    PICTURES.mkdir(exist_ok=True)
    overlay(sample_results()[-1], 'overlay.png')
    with browsing() as driver:
        with page_under_test(driver) as stage:
            page(stage)
        report(driver)
        control(driver)
        new_ink(driver)
