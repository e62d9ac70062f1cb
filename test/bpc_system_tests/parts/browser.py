"""A real browser for page and report: Debian's Chromium without a window."""

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

REQUIRED_VARIABLE = 'BPC_BROWSER_TESTS'  # "required": tests fail without a browser
PROGRAMS = ('chromium', 'chromedriver')
DESKTOP_PX, PHONE_PX = (1400, 1000), (390, 844)


def missing() -> str:
    """Say which programs are missing for a browser; empty = none."""
    lacking = [name for name in PROGRAMS if shutil.which(name) is None]
    return (f'needs {" and ".join(lacking)}; on Debian: apt install chromium chromium-driver'
            if lacking else '')


def required() -> bool:
    """Tell whether tests have to fail where there is no browser."""
    return os.environ.get(REQUIRED_VARIABLE) == 'required'


@contextmanager
def browsing() -> Iterator[webdriver.Chrome]:
    """Run a new browser that records its console and its network requests."""
    options = webdriver.ChromeOptions()
    options.binary_location = str(shutil.which('chromium'))
    # A container has no sandbox, and little shared memory.
    for option in ('headless=new', 'no-sandbox', 'disable-dev-shm-usage', 'disable-gpu',
                   'hide-scrollbars'):
        options.add_argument(f'--{option}')
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL', 'performance': 'ALL'})
    driver = webdriver.Chrome(options, Service(str(shutil.which('chromedriver'))))
    try:
        show_as(driver, DESKTOP_PX)
        yield driver
    finally:
        driver.quit()


def show_as(driver: webdriver.Chrome, size: tuple[int, int], dark: bool = False) -> None:
    """Set the size of the browser's page [pixels] and its preference for light or dark."""
    width, height = size
    driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
        'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': width < 500})
    driver.execute_cdp_cmd('Emulation.setEmulatedMedia', {'features': [
        {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}]})


def errors(driver: webdriver.Chrome) -> list[str]:
    """Return the errors in the console since the last call.

    Warnings are left out: they tell that drawing is slow without a graphics card.
    """
    return [entry['message'] for entry in driver.get_log('browser')
            if entry['level'] == 'SEVERE']


def requested_hosts(driver: webdriver.Chrome) -> set[str]:
    """Return the hosts of all requests since the last call; '' for files and data."""
    messages: list[dict[str, Any]] = [json.loads(entry['message'])['message']
                                      for entry in driver.get_log('performance')]
    requests = [message['params']['request']['url'] for message in messages
                if message['method'] == 'Network.requestWillBeSent']
    requests += [message['params']['url'] for message in messages
                 if message['method'] == 'Network.webSocketCreated']
    return {urlsplit(address).hostname or '' for address in requests}
