"""A live page, the printer that it shows, and the browser that displays it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
import os
from typing import Any
from urllib.error import URLError
from urllib.request import urlopen

from selenium.common.exceptions import (
    ElementClickInterceptedException,
    ElementNotInteractableException,
    NoSuchElementException,
    StaleElementReferenceException,
)
from selenium.webdriver import Chrome
from selenium.webdriver.common.by import By

from bpc_perception.cli.parts.live_page import free_port
from bpc_perception.core.result import Result
from bpc_perception.page import TOKEN_VARIABLE
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.isolated_graph import Graph
from bpc_system_tests.parts.command_line import PATIENCE_S
from bpc_system_tests.parts.fake_printer import FakePrinter
from bpc_system_tests.parts.ros_graph import own_domain
from bpc_system_tests.parts.sample_print import sample_results

TOKEN = 'a-token-of-the-tests'


@dataclass
class PageUnderTest:
    """A printer, the page that shows it, and the browser that displays the page.

    Attributes:
        graph: graph of the printer.
        printer: publishes the results.
        nodes: the process of the page.
        port: port of the page.
        results: captures of the sample print, measured.
        driver: the browser.
    """

    graph: Graph
    printer: FakePrinter
    nodes: Nodes
    port: int
    results: list[Result]
    driver: Chrome

    def address(self, token: str | None = TOKEN) -> str:
        """Return the address of the page, with a token or without."""
        return f'http://127.0.0.1:{self.port}/' + (f'?token={token}' if token else '')

    def wait(self, condition: Callable[[], Any]) -> None:
        """Spin the printer until a condition holds."""
        self.graph.spin_until(condition, PATIENCE_S)

    def text(self, selector: str) -> str:
        """Return the text of elements of the page."""
        # In one step: between two steps the page may replace the elements.
        return str(self.driver.execute_script(
            'return [...document.querySelectorAll(arguments[0])]'
            '.map(element => element.innerText).join("\\n")', selector))

    def press(self, selector: str) -> None:
        """Click an element as soon as nothing moves: a click on a moving element misses it."""
        def clicked() -> bool:
            if self.driver.execute_script('return document.getAnimations().length'):
                return False
            try:
                self.driver.find_element(By.CSS_SELECTOR, selector).click()
            except (ElementClickInterceptedException, ElementNotInteractableException,
                    NoSuchElementException, StaleElementReferenceException):
                return False
            return True

        self.wait(clicked)

    def open(self, token: str | None = TOKEN) -> None:
        """Open the page, and wait until it is connected."""
        self.driver.get(self.address(token))
        self.wait(lambda: self.driver.execute_script(
            'return window.did_handshake === true && !!document.querySelector(".headline")'))
        self.wait(lambda: self.printer.overlays.get_subscription_count() == 1)

    def show(self, capture: int) -> None:
        """Publish a capture, and wait until the page has it."""
        self.printer.publish(self.results[capture])
        self.wait(lambda: self.text('.capture').startswith(f'capture {capture},'))

    def start_page(self) -> None:
        """Start the page's process, and wait until it listens."""
        os.environ[TOKEN_VARIABLE] = TOKEN
        self.nodes.start('bpc_perception.nodes.page', port=self.port)
        del os.environ[TOKEN_VARIABLE]
        self.wait(lambda: self.nodes.check() or self.printer.heard)
        self.wait(lambda: answers(self.address()))


def answers(address: str) -> bool:
    """Tell whether a page is served at an address."""
    try:
        with urlopen(address, timeout=PATIENCE_S) as answer:
            return int(answer.status) == 200
    except URLError:
        return False


@contextmanager
def page_under_test(driver: Chrome) -> Iterator[PageUnderTest]:
    """Run a page that shows nothing yet, in a graph of its own."""
    with own_domain() as domain, Nodes() as nodes:
        graph = Graph(domain)
        try:
            made = PageUnderTest(graph, FakePrinter(graph), nodes, free_port(0),
                                 sample_results(), driver)
            made.start_page()
            yield made
        finally:
            driver.get('about:blank')
            graph.close()
