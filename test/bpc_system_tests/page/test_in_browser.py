"""In a real browser: the live page, what it shows and who may act; and report.html."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
import os
from pathlib import Path
import re
import signal
import time
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
import pytest
from selenium.common.exceptions import WebDriverException
from selenium.webdriver import Chrome
from selenium.webdriver.common.by import By
from selenium.webdriver.support.wait import WebDriverWait

from bpc_perception.core.design.comparison import compare_with_design, path_of, WantedDesign
from bpc_perception.core.design.design import Design, DesignStroke
from bpc_perception.display.overlay import draw_overlay
from bpc_system_tests.parts.browser import (
    DESKTOP_PX,
    errors,
    PHONE_PX,
    requested_hosts,
    show_as,
)
from bpc_system_tests.parts.command_line import PATIENCE_S, running, SAMPLE
from bpc_system_tests.parts.page_under_test import (
    answers,
    page_under_test,
    PageUnderTest,
    TOKEN,
)

pytestmark = [pytest.mark.system, pytest.mark.ros]

LOOPBACK = {'127.0.0.1', ''}  # '': data within the page


@pytest.fixture(scope='module')
def page(browser: Chrome) -> Iterator[PageUnderTest]:
    """A page without a print so far, and a browser that shows another page."""
    with page_under_test(browser) as made:
        yield made


def refused(request: Request | str) -> tuple[int, str]:
    """Return status and text of an answer that refuses the request."""
    with pytest.raises(HTTPError) as refusal, urlopen(request, timeout=PATIENCE_S):
        pass
    with refusal.value as error:
        return error.code, error.read().decode()


def drawn(page: PageUnderTest) -> dict[str, Any]:
    """Return the points of each curve in the chart, by name."""
    series = page.driver.execute_script(
        'const chart = document.querySelector(".chart");'
        'return getElement(Number(chart.id.slice(1))).chart.getOption()?.series ?? []')
    return {each['name']: each['data'] for each in series}


def test_a_wrong_token_is_refused(page: PageUnderTest) -> None:
    for token in ('wrong', '%20', TOKEN + 'x'):
        status, words = refused(page.address(token))
        assert status == 403
        assert TOKEN not in words


@pytest.mark.parametrize(('header', 'value'), [
    ('Host', 'evil.example'), ('Host', f'{TOKEN}.example:80'),
    ('Origin', 'http://evil.example'), ('Origin', 'null')])
def test_who_comes_by_another_name_is_refused(page: PageUnderTest, header: str,
                                              value: str) -> None:
    for path in ('', '_nicegui_ws/socket.io/?EIO=4&transport=polling', 'overlay.jpg'):
        request = Request(page.address(None) + path, headers={header: value})
        assert refused(request)[0] == 403


def test_it_is_to_be_had_on_loopback_only(page: PageUnderTest) -> None:
    with open('/proc/net/tcp', encoding='ascii') as file:
        listening = [line.split()[1] for line in file if line.split()[3] == '0A']
    ours = [local for local in listening if int(local.split(':')[1], 16) == page.port]
    assert ours == [f'0100007F:{page.port:04X}']


def test_nobody_listens_to_the_overlay_while_nobody_looks(page: PageUnderTest) -> None:
    assert page.printer.overlays.get_subscription_count() == 0
    page.printer.publish(page.results[1])
    page.open()
    # What was measured before the page was opened is shown, too.
    page.wait(lambda: page.text('.capture').startswith('capture 1,'))


def test_a_print_is_shown(page: PageUnderTest) -> None:
    page.show(3)
    profile, advice = page.results[3].profile, page.results[3].advice
    assert profile is not None
    assert advice is not None
    assert page.text('.print') == profile.print_id
    assert page.text('.headline') == f'flow × {advice.flow_rate_scale:.2f}'
    assert page.text('.reason') == 'what is laid now comes out too thick'
    assert f'{profile.summary.thickness_mean * 1e3:.2f}' in page.text('.area-numbers')
    assert page.text('.area-events').count('gap of') == 1
    page.wait(lambda: page.text('.verdict') == 'not good: 1 × gap')
    page.wait(lambda: page.text('.age').endswith('s old'))
    page.wait(lambda: 'dead band height' in drawn(page))
    series = drawn(page)
    assert len(series['thickness']) == len(profile)
    assert series['target'][0][1] == 2.0
    assert series['dead band height'][0][1] == 0.08  # 2 % to either side
    page.wait(lambda: page.driver.execute_script(
        'return document.querySelector(".overlay img")?.naturalWidth')
               == draw_overlay(page.results[3]).shape[1])


def test_how_far_a_print_is_from_its_design_is_shown(page: PageUnderTest) -> None:
    """The design is what the last capture has of the path; at the one before it is not over."""
    before, last = (page.results[number].profile for number in (2, 3))
    assert before is not None
    assert last is not None
    laid = [np.flatnonzero(last.stroke == number) for number in last.strokes.number]
    wanted = WantedDesign('vase.csv', Design(tuple(
        DesignStroke(last.points[own], np.full(len(own) - 1, 2e-3)) for own in laid)))
    found = compare_with_design(before, wanted, path_of(before, False))
    assert page.text('.design') == ''
    page.printer.publish(replace(page.results[3], design=found))
    page.wait(lambda: page.text('.design').startswith('beside its design: nozzle off by up to 0.'))
    assert re.search(r'layer fidelity \d+%, \d+ mm to come$', page.text('.design'))


def test_a_new_capture_is_shown_to_all_who_look(
        page: PageUnderTest, record_property: Callable[[str, object], None]) -> None:
    first = page.driver.current_window_handle
    page.driver.switch_to.new_window('tab')
    page.driver.get(page.address(None))
    page.wait(lambda: page.text('.capture').startswith('capture 3,'))
    show_as(page.driver, PHONE_PX)
    wide = page.driver.execute_script('return document.documentElement.scrollWidth')
    assert wide <= PHONE_PX[0]  # no scrolling to the side
    sent = time.monotonic()
    page.show(4)
    record_property('profile to page [s]', time.monotonic() - sent)
    page.driver.close()
    page.driver.switch_to.window(first)
    page.wait(lambda: page.text('.capture').startswith('capture 4,'))
    assert page.text('.headline').startswith('flow')


def test_without_a_token_there_are_no_buttons(page: PageUnderTest) -> None:
    page.driver.get(page.address(None))
    page.wait(lambda: page.text('.headline'))
    assert page.driver.find_elements(By.CSS_SELECTOR, 'button') == []


def test_buttons_do_what_they_say(page: PageUnderTest) -> None:
    page.open()
    for name in ('capture', 'start', 'stop', 'save'):
        page.press(f'.action-{name}')
        if name in ('start', 'stop'):
            page.wait(lambda: page.text('.sure'))
            # The button asks for confirmation first.
            assert f'path_recorder/{name}' not in page.printer.called
            page.press('.sure')
        page.wait(lambda name=name: f'{name} done' in page.text('.outcome'))
    assert page.printer.called == ['capture', 'path_recorder/start', 'path_recorder/stop',
                                    'path_recorder/save']


def test_nodes_that_warn_and_nodes_that_are_silent_are_seen(page: PageUnderTest) -> None:
    page.printer.say('thickness', DiagnosticStatus.WARN, 'pose: <b>too late</b>')
    page.wait(lambda: 'thickness\n' in page.text('.entry.warn .name') + '\n')
    assert 'pose: <b>too late</b>' in page.text('.area-events')  # as text, not as markup
    assert 'not heard yet' in page.text('.area-nodes')  # the path recorder
    page.wait(lambda: 'silent for' in page.text('.area-nodes'))


def test_it_asks_nobody_else_and_has_no_errors(page: PageUnderTest) -> None:
    hosts = requested_hosts(page.driver)
    assert '127.0.0.1' in hosts
    assert hosts <= LOOPBACK
    assert errors(page.driver) == []


def test_a_page_that_was_restarted_is_found_again(page: PageUnderTest) -> None:
    os.kill(page.nodes.pid('page'), signal.SIGTERM)
    page.wait(lambda: page.nodes.ended('page'))
    page.wait(lambda: page.driver.execute_script(
        'return document.getElementById("popup").ariaHidden') == 'false')
    page.start_page()
    page.wait(lambda: page.text('.headline') == 'no advice yet')
    page.wait(lambda: page.printer.overlays.get_subscription_count() == 1)
    page.show(2)
    errors(page.driver)  # those of the lost connection


def test_it_acts_on_a_live_print(browser: Chrome, ros_domain: int) -> None:
    assert ros_domain
    with running('live', '--page', '--no-save', '--handeye', SAMPLE / 'hand_eye.calib',
                 '--params', SAMPLE / 'params.yaml') as live:
        assert live.stdout is not None
        address = next(found[0] for line in live.stdout
                       if (found := re.findall(r'http://127\.0\.0\.1:\S+', line)))
        patience = WebDriverWait(browser, PATIENCE_S, ignored_exceptions=[WebDriverException])
        patience.until(lambda _: answers(address))
        browser.get(address)
        shown = 'return document.querySelector("{}").innerText'
        patience.until(lambda _: re.fullmatch(
            r'path_recorder\s+\S+, \S+: expected messages, heard of none yet\s+thickness\s+ok',
            browser.execute_script(shown.format('.area-nodes .entries')).strip()))
        browser.find_element(By.CSS_SELECTOR, '.action-start').click()
        patience.until(lambda _: re.search(
            r'Start: \d{8}T\d{6}', browser.execute_script(shown.format('.outcome'))))
        browser.get('about:blank')
    assert errors(browser) == []


def test_report_opens_without_a_network(measured_sample: Path, browser: Chrome) -> None:
    for before in (requested_hosts, errors):
        before(browser)
    browser.get((measured_sample / 'report.html').as_uri())
    assert 'mm' in browser.execute_script('return document.body.innerText')
    pictures = browser.execute_script(
        'return [...document.images].map(image => image.complete && image.naturalWidth > 0)')
    assert all(pictures)
    # Scripts draw the figures; the report contains them.
    assert browser.execute_script('return document.querySelectorAll("svg, canvas").length') > 0
    for size in (PHONE_PX, DESKTOP_PX):
        show_as(browser, size)
        assert browser.execute_script(
            'return [...document.querySelectorAll(".image, .chart")].filter('
            'each => each.getBoundingClientRect().right > arguments[0]).length', size[0]) == 0
    assert requested_hosts(browser) == {''}
    assert errors(browser) == []
