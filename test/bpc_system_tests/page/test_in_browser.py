"""In a real browser: the live page, what it shows and who may act; and report.html."""

from __future__ import annotations

from collections.abc import Callable, Iterator
import os
from pathlib import Path
import re
import signal
import time
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

from diagnostic_msgs.msg import DiagnosticStatus
import pytest
from selenium.common.exceptions import WebDriverException
from selenium.webdriver import Chrome
from selenium.webdriver.common.by import By
from selenium.webdriver.support.wait import WebDriverWait

from bpc_perception.display.overlay import draw_overlay
from bpc_system_tests.parts.browser import asked, DESKTOP, errors, PHONE, show_as
from bpc_system_tests.parts.command_line import running, SAMPLE
from bpc_system_tests.parts.page_stage import answers, Stage, staged, TOKEN
from bpc_system_tests.parts.ros_graph import PATIENCE

pytestmark = [pytest.mark.system, pytest.mark.ros]

LOOPBACK = {'127.0.0.1', ''}  # '': data within the page


@pytest.fixture(scope='module')
def stage(browser: Chrome) -> Iterator[Stage]:
    """A page without a print so far, and a browser that is somewhere else."""
    with staged(browser) as made:
        yield made


def refused(request: Request | str) -> tuple[int, str]:
    """Status and words of an answer that is a refusal."""
    with pytest.raises(HTTPError) as refusal, urlopen(request, timeout=PATIENCE):
        pass
    with refusal.value as error:
        return error.code, error.read().decode()


def drawn(stage: Stage) -> dict[str, Any]:
    """The points of each curve in the chart, by name."""
    series = stage.driver.execute_script(
        'const chart = document.querySelector(".chart");'
        'return getElement(Number(chart.id.slice(1))).chart.getOption()?.series ?? []')
    return {each['name']: each['data'] for each in series}


def test_a_wrong_token_is_refused(stage: Stage) -> None:
    for token in ('wrong', '%20', TOKEN + 'x'):
        status, words = refused(stage.address(token))
        assert status == 403
        assert TOKEN not in words


@pytest.mark.parametrize(('header', 'value'), [
    ('Host', 'evil.example'), ('Host', f'{TOKEN}.example:80'),
    ('Origin', 'http://evil.example'), ('Origin', 'null')])
def test_who_comes_by_another_name_is_refused(stage: Stage, header: str, value: str) -> None:
    for path in ('', '_nicegui_ws/socket.io/?EIO=4&transport=polling', 'overlay.jpg'):
        request = Request(stage.address(None) + path, headers={header: value})
        assert refused(request)[0] == 403


def test_it_is_to_be_had_on_loopback_only(stage: Stage) -> None:
    with open('/proc/net/tcp', encoding='ascii') as file:
        listening = [line.split()[1] for line in file if line.split()[3] == '0A']
    ours = [local for local in listening if int(local.split(':')[1], 16) == stage.port]
    assert ours == [f'0100007F:{stage.port:04X}']


def test_nobody_listens_to_the_overlay_while_nobody_looks(stage: Stage) -> None:
    assert stage.printer.overlays.get_subscription_count() == 0
    stage.printer.publish(stage.results[1])
    stage.open()
    # What was measured before somebody came to look is there all the same.
    stage.wait(lambda: stage.text('.capture').startswith('capture 1,'))


def test_a_print_is_shown(stage: Stage) -> None:
    stage.show(3)
    profile, advice = stage.results[3].profile, stage.results[3].advice
    assert profile is not None
    assert advice is not None
    assert stage.text('.print') == profile.print_id
    assert stage.text('.headline') == f'flow × {advice.flow_rate_scale:.2f}'
    assert stage.text('.reason') == 'what is laid now comes out too thick'
    assert f'{profile.summary.thickness_mean * 1e3:.2f}' in stage.text('.area-numbers')
    assert stage.text('.area-events').count('gap of') == 3
    stage.wait(lambda: stage.text('.age').endswith('s old'))
    stage.wait(lambda: 'dead band height' in drawn(stage))
    series = drawn(stage)
    assert len(series['thickness']) == len(profile)
    assert series['target'][0][1] == 2.0
    assert series['dead band height'][0][1] == 0.08  # 2 % to either side
    stage.wait(lambda: stage.driver.execute_script(
        'return document.querySelector(".overlay img")?.naturalWidth')
               == draw_overlay(stage.results[3]).shape[1])


def test_a_new_capture_is_shown_to_all_who_look(
        stage: Stage, record_property: Callable[[str, object], None]) -> None:
    first = stage.driver.current_window_handle
    stage.driver.switch_to.new_window('tab')
    stage.driver.get(stage.address(None))
    stage.wait(lambda: stage.text('.capture').startswith('capture 3,'))
    show_as(stage.driver, PHONE)
    wide = stage.driver.execute_script('return document.documentElement.scrollWidth')
    assert wide <= PHONE[0]  # nothing has to be scrolled to the side
    sent = time.monotonic()
    stage.show(4)
    record_property('profile to page [s]', time.monotonic() - sent)
    stage.driver.close()
    stage.driver.switch_to.window(first)
    stage.wait(lambda: stage.text('.capture').startswith('capture 4,'))
    assert stage.text('.headline').startswith('flow')


def test_without_a_token_there_are_no_buttons(stage: Stage) -> None:
    stage.driver.get(stage.address(None))
    stage.wait(lambda: stage.text('.headline'))
    assert stage.driver.find_elements(By.CSS_SELECTOR, 'button') == []


def test_buttons_do_what_they_say(stage: Stage) -> None:
    stage.open()
    for name in ('capture', 'start', 'stop', 'save'):
        stage.press(f'.action-{name}')
        if name == 'stop':
            stage.wait(lambda: stage.text('.sure'))
            assert stage.printer.called[-1] == 'path_recorder/start'  # it is asked first
            stage.press('.sure')
        stage.wait(lambda name=name: f'{name} done' in stage.text('.outcome'))
    assert stage.printer.called == ['capture', 'path_recorder/start', 'path_recorder/stop',
                                    'path_recorder/save']


def test_nodes_that_warn_and_nodes_that_are_silent_are_seen(stage: Stage) -> None:
    stage.printer.say('thickness', DiagnosticStatus.WARN, 'pose: <b>too late</b>')
    stage.wait(lambda: 'thickness\n' in stage.text('.entry.warn .name') + '\n')
    assert 'pose: <b>too late</b>' in stage.text('.area-events')  # as text, not as markup
    assert 'not heard yet' in stage.text('.area-nodes')  # the path recorder
    stage.wait(lambda: 'silent for' in stage.text('.area-nodes'))


def test_it_asks_nobody_else_and_has_no_errors(stage: Stage) -> None:
    hosts = asked(stage.driver)
    assert '127.0.0.1' in hosts
    assert hosts <= LOOPBACK
    assert errors(stage.driver) == []


def test_a_page_that_was_restarted_is_found_again(stage: Stage) -> None:
    os.kill(stage.nodes.pid('page'), signal.SIGTERM)
    stage.wait(lambda: stage.nodes.ended('page'))
    stage.wait(lambda: stage.driver.execute_script(
        'return document.getElementById("popup").ariaHidden') == 'false')
    stage.start_page()
    stage.wait(lambda: stage.text('.headline') == 'no advice yet')
    stage.wait(lambda: stage.printer.overlays.get_subscription_count() == 1)
    stage.show(2)
    errors(stage.driver)  # of the connection that was lost


def test_it_acts_on_a_live_print(browser: Chrome, ros_domain: int) -> None:
    assert ros_domain
    with running('live', '--page', '--handeye', SAMPLE / 'hand_eye.calib',
                 '--params', SAMPLE / 'params.yaml') as live:
        assert live.stdout is not None
        address = next(found[0] for line in live.stdout
                       if (found := re.findall(r'http://127\.0\.0\.1:\S+', line)))
        patience = WebDriverWait(browser, PATIENCE, ignored_exceptions=[WebDriverException])
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
    for before in (asked, errors):
        before(browser)
    browser.get((measured_sample / 'report.html').as_uri())
    assert 'mm' in browser.execute_script('return document.body.innerText')
    pictures = browser.execute_script(
        'return [...document.images].map(image => image.complete && image.naturalWidth > 0)')
    assert all(pictures)
    # Its figures are drawn by scripts, which the report brings along.
    assert browser.execute_script('return document.querySelectorAll("svg, canvas").length') > 0
    for size in (PHONE, DESKTOP):
        show_as(browser, size)
        assert browser.execute_script(
            'return [...document.querySelectorAll(".image, .chart")].filter('
            'each => each.getBoundingClientRect().right > arguments[0]).length', size[0]) == 0
    assert asked(browser) == {''}
    assert errors(browser) == []
