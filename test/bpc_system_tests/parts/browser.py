"""A real browser, Debian's Chromium without a window, for the page and the report."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import json
import os
import shutil
from typing import Any
from urllib.parse import urlsplit

from selenium import webdriver
from selenium.webdriver.chrome.service import Service

REQUIRED = 'BPC_BROWSER_TESTS'  # "required": without a browser the tests fail
PROGRAMS = ('chromium', 'chromedriver')
DESKTOP, PHONE = (1400, 1000), (390, 844)


def missing() -> str:
    """What a browser lacks here; empty = nothing."""
    lacking = [name for name in PROGRAMS if shutil.which(name) is None]
    return (f'needs {" and ".join(lacking)}; on Debian: apt install chromium chromium-driver'
            if lacking else '')


def required() -> bool:
    """Whether the tests may not be skipped for want of a browser."""
    return os.environ.get(REQUIRED) == 'required'


@contextmanager
def browsing() -> Iterator[webdriver.Chrome]:
    """A browser of its own, which keeps what it logs and asks of the network."""
    options = webdriver.ChromeOptions()
    options.binary_location = str(shutil.which('chromium'))
    # In a container there is no sandbox to be had, and little shared memory.
    for option in ('headless=new', 'no-sandbox', 'disable-dev-shm-usage', 'disable-gpu',
                   'hide-scrollbars'):
        options.add_argument(f'--{option}')
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL', 'performance': 'ALL'})
    driver = webdriver.Chrome(options, Service(str(shutil.which('chromedriver'))))
    try:
        show_as(driver, DESKTOP)
        yield driver
    finally:
        driver.quit()


def show_as(driver: webdriver.Chrome, size: tuple[int, int], dark: bool = False) -> None:
    """Give the browser's page a size [pixels] and a preference for a light or dark one."""
    width, height = size
    driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
        'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': width < 500})
    driver.execute_cdp_cmd('Emulation.setEmulatedMedia', {'features': [
        {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}]})


def errors(driver: webdriver.Chrome) -> list[str]:
    """The errors in the console since the last call.

    Not its warnings: how slow a drawing is without a graphics card does not matter here.
    """
    return [entry['message'] for entry in driver.get_log('browser')
            if entry['level'] == 'SEVERE']


def asked(driver: webdriver.Chrome) -> set[str]:
    """The hosts asked since the last call; empty for files and data."""
    messages: list[dict[str, Any]] = [json.loads(entry['message'])['message']
                                      for entry in driver.get_log('performance')]
    requests = [message['params']['request']['url'] for message in messages
                if message['method'] == 'Network.requestWillBeSent']
    requests += [message['params']['url'] for message in messages
                 if message['method'] == 'Network.webSocketCreated']
    return {urlsplit(address).hostname or '' for address in requests}
