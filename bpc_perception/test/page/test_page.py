"""What the live page shows, and whom it answers."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import Any

import numpy as np
from perception_builders import advice_of, on_one_layer
import pytest
from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets
from bpc_perception.page import board as boards
from bpc_perception.page.board import Board, Level, overlay_of, TargetBand
from bpc_perception.page.chart import options
from bpc_perception.page.curve import stretches, thinned
from bpc_perception.page.guard import Guard, HEADERS

SPACING_M = 2e-4  # of samples
TOKEN = 'secret'


def profile(count: int) -> ThicknessProfile:
    """A print of 2 mm with one thick and one thin sample, a gap of 10 samples and one unseen."""
    nothing = np.full(count, np.nan)
    thickness = np.full(count, 2e-3)
    status = np.zeros(count, np.uint8)
    thickness[150], thickness[170] = 2.5e-3, 1.5e-3
    status[100:110], thickness[100:110] = Status.GAP, 0.0
    status[40], thickness[40] = Status.NO_DATA, np.nan
    points = np.zeros((count, 3))
    return ThicknessProfile(
        stamp_ns=0, print_id='print', print_start_ns=0, capture=0, method='cross_section',
        time=np.arange(count) * 0.01, arc_length=np.arange(count) * SPACING_M, points=points,
        extruding=np.ones(count, bool), extruder_known=np.ones(count, bool),
        stroke=np.ones(count, np.intp), status=status, thickness=thickness,
        sigma=np.where(status == Status.MEASURED, 1e-5, np.nan), left=nothing, right=nothing,
        left_points=points, right_points=points, **on_one_layer(count), processing_time=0.0)


@pytest.mark.parametrize('count', [200, 10_000, 100_000])
def test_a_curve_stays_small_and_keeps_extremes_and_interruptions(count: int) -> None:
    curve = thinned(profile(count), most=300)
    assert len(curve.arc_length) <= min(count, 300)
    assert np.nanmax(curve.thickness) == 2.5e-3
    assert np.nanmin(curve.thickness) == 1.5e-3  # the 0 of a gap does not count
    assert (np.diff(curve.arc_length) > 0).all()
    interrupted = curve.arc_length[np.isnan(curve.thickness)]
    assert interrupted[0] == 40 * SPACING_M
    assert np.isnan(curve.sigma).tolist() == np.isnan(curve.thickness).tolist()


def test_a_curve_of_the_newest_has_nothing_before() -> None:
    curve = thinned(profile(200), start=150 * SPACING_M)
    assert curve.arc_length[0] >= 150 * SPACING_M
    assert len(curve.arc_length) == 50


def test_stretches_say_where_nothing_was_measured() -> None:
    unseen, gap = stretches(profile(200))
    assert (unseen.status, gap.status) == (Status.NO_DATA, Status.GAP)
    assert (unseen.start, unseen.end) == pytest.approx((39.5 * SPACING_M, 40.5 * SPACING_M))
    assert (gap.start, gap.end) == pytest.approx((99.5 * SPACING_M, 109.5 * SPACING_M))
    assert [each.status for each in stretches(profile(200), most=1)] == [Status.GAP]
    assert stretches(profile(200), start=120 * SPACING_M) == []


def test_the_chart_shows_a_step_of_the_target_as_a_step() -> None:
    step = WidthTargets(np.array([0.0, 0.01, 0.01]), np.array([2e-3, 2e-3, 3e-3]))
    band = TargetBand(step, 0.02)
    drawn = options(thinned(profile(200)), [], band, (0.0, 0.04), dark=False)
    target = next(each for each in drawn['series'] if each['name'] == 'target')
    assert target['data'] == [[0, 2.0], [10, 2.0], [10, 3.0], [40, 3.0]]
    height = next(each for each in drawn['series'] if each['name'] == 'dead band height')
    assert height['data'][0] == [0, 0.08]
    assert drawn['yAxis']['min'] < 1.5
    assert drawn['yAxis']['max'] > 3.0


def test_the_chart_of_nothing_is_empty() -> None:
    nothing = thinned(replace(profile(200), status=np.full(200, Status.NO_DATA, np.uint8)))
    drawn = options(nothing, [], None, (0.0, 0.04), dark=True)
    thickness = next(each for each in drawn['series'] if each['name'] == 'thickness')
    assert {point[1] for point in thickness['data']} == {None}
    assert drawn['yAxis']['min'] < drawn['yAxis']['max']


def test_a_silent_node_is_not_well(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(boards.time, 'monotonic', lambda: now[0])
    board = Board(lambda: 0)
    board.hear('thickness', Level.OK, 'ok')
    assert board.health() == {'path_recorder': (Level.UNHEARD, 'not heard yet'),
                              'thickness': (Level.OK, 'ok')}
    now[0] += 4
    assert board.health()['thickness'] == (Level.STALE, 'silent for 4 s')
    now[0] += 8
    assert board.health()['thickness'] == (Level.ERROR, 'silent for 12 s')


def test_of_a_dead_node_its_supervisor_speaks() -> None:
    board = Board(lambda: 0)
    board.hear('thickness', Level.STALE, 'captures: expected messages, heard of none yet')
    board.hear('supervisor: thickness', Level.OK, 'ok')
    assert board.health()['thickness'][0] == Level.STALE
    assert board.events == ()
    board.hear('supervisor: thickness', Level.ERROR, 'ended with status -9')
    assert board.health() == {'path_recorder': (Level.UNHEARD, 'not heard yet'),
                              'thickness': (Level.ERROR, 'ended with status -9')}
    assert [(event.source, event.alarm) for event in board.events] == [('thickness', True)]
    board.hear('supervisor: thickness', Level.OK, 'ok')
    assert board.health()['thickness'][0] == Level.STALE


def test_events_of_one_kind_are_one_and_all_are_few() -> None:
    board = Board(lambda: 0)
    board.hear('camera', Level.ERROR, 'no light')
    for late in range(5):
        board.hear('thickness', Level.WARN, f'pose: {late} s late')
    board.advise(advice_of(Reason.GAP_DETECTED, valid=False))
    board.advise(advice_of(Reason.ON_TARGET))
    assert [(event.source, event.words, event.alarm, event.times) for event in board.events] == [
        ('advice', 'gap detected', True, 1), ('thickness', 'pose: 4 s late', False, 5),
        ('camera', 'no light', True, 1)]
    for number in range(100):
        board.hear('camera', Level.WARN, f'{number}')
    assert len(board.events) == boards.MOST_EVENTS


def test_an_overlay_is_never_large() -> None:
    noise = np.random.default_rng(0).integers(0, 256, (1200, 1944, 3), np.uint8)
    assert len(overlay_of(1, noise).jpeg) < 2_000_000
    assert len(overlay_of(1, noise // 16 * 4 + 96).jpeg) < 700_000


def ask(query: str = '', kind: str = 'http', **headers: str) -> list[Any]:
    """Return what a guarded application sends in answer to such a request."""
    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await PlainTextResponse('welcome')(scope, receive, send)

    asked_for = {'host': '127.0.0.1:8770', **headers}
    scope = {'type': kind, 'path': '/', 'query_string': query.encode(), 'headers': [
        (name.encode(), value.encode()) for name, value in asked_for.items()]}
    asyncio.run(Guard(app, TOKEN)(scope, None, send))  # type: ignore[arg-type]
    return sent


@pytest.mark.parametrize('host', ['127.0.0.1:8770', 'localhost:8770', 'localhost:9000',
                                  'localhost'])
def test_who_comes_by_our_address_is_let_in(host: str) -> None:
    for query in ('', f'token={TOKEN}', 'capture=1'):
        start, body = ask(query, host=host, origin=f'http://{host}')
        assert (start['status'], body['body']) == (200, b'welcome')
        found = Headers(raw=start['headers'])
        assert {name: found[name] for name in HEADERS} == HEADERS


@pytest.mark.parametrize('query', ['token=', 'token=Secret', 'token=secret%20',
                                   f'token={TOKEN}&token=other', 'token=%C3%A9', 'token=%ff'])
def test_a_wrong_token_is_refused(query: str) -> None:
    start, body = ask(query)
    assert start['status'] == 403
    assert TOKEN.encode() not in body['body']


@pytest.mark.parametrize('headers', [
    {'host': 'evil.example'}, {'host': 'evil.example:8770'}, {'host': '127.0.0.1.evil.example'},
    {'host': '127.0.0.1:8770@evil.example'}, {'host': ''},
    {'origin': 'http://evil.example'}, {'origin': 'null'}, {'origin': 'http://127.0.0.1:1234'}])
def test_who_comes_by_another_address_is_refused(headers: dict[str, str]) -> None:
    assert ask(**headers)[0]['status'] == 403
    assert ask(kind='websocket', **headers) == [{'type': 'websocket.close', 'code': 1008}]


def test_a_curve_of_a_layer_ends_with_it_and_has_its_heights() -> None:
    known = replace(profile(200), height=np.full(200, 5e-4))
    curve = thinned(known, start=50 * SPACING_M, end=99.5 * SPACING_M)
    assert len(curve.arc_length) == 50
    np.testing.assert_array_equal(curve.height, 5e-4)
    series = options(curve, [], None, (0.01, 0.02), dark=False)['series']
    (height,) = [each for each in series if each['name'] == 'height']
    assert height['data'][0][1] == 0.5
