"""The report: carries everything it shows, says it in words, and draws where things are."""

import base64
from dataclasses import replace
from html.parser import HTMLParser
import json

import numpy as np
import pytest

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.session import Result
from bpc_perception.display import legend, overlay, wording
from bpc_perception.report import figures, html
from bpc_perception.report.outputs import summarize
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import Provenance
from bpc_perception.report.thumbnails import decode, encode, MOST, Thumbnails

MM = 1e-3
NASTY = '</script><script>alert("1")</script>&<b>'


@pytest.fixture
def result():
    """A strand along x, 2 mm wide, one pixel a millimetre; its third sample is a gap."""
    count = 20
    x = np.arange(count) * MM
    points = np.column_stack((x, np.zeros(count), np.full(count, 0.1)))
    status = np.full(count, Status.MEASURED, np.uint8)
    status[2] = Status.GAP
    measured = np.where(status == Status.MEASURED, 1.0, np.nan)
    camera = PinholeCamera(np.array(((100.0, 0, 5), (0, 100.0, 12), (0, 0, 1))), np.zeros(5),
                           32, 24)
    image = np.zeros((24, 32, 3), np.uint8)
    image[:, :16] = (200, 40, 10)
    return Result(
        Capture(10**9, 'camera', image, np.full((24, 32, 3), np.nan, np.float32), camera),
        np.eye(4),
        ThicknessProfile(
            stamp_ns=10**9, print_id=NASTY, print_start_ns=0, capture=0, method='paper',
            time=x, arc_length=x, points=points, extruding=np.ones(count, bool), status=status,
            thickness=np.where(status == Status.GAP, 0.0, 2 * MM), sigma=0.1 * MM * measured,
            left=MM * measured, right=MM * measured,
            left_points=(points - (0, MM, 0)) * measured[:, None],
            right_points=(points - (0, -MM, 0)) * measured[:, None], processing_time=0.1),
        RateAdvice(10**9, NASTY, True, Reason.UNDER_EXTRUSION, 2.078 * MM, 2 * MM,
                   (5 * MM, 19 * MM), 14, 1.0795, 0.926, 0.9, 0.5, 6 * 10**9))


TARGETS = WidthTargets.constant(2.078 * MM)


def rendered(result):
    log = PrintLog.of([Result(result.capture, refusal='no <deposit>'), result])
    return html.render(log, summarize(log, Provenance(
        f'{NASTY}.mcap', 'cell.calib', {'advice.dead_band': 0.03}, {'bpc': '0.1.0'}, TARGETS)),
        TARGETS)


@pytest.fixture
def page(result):
    return rendered(result)


class Elements(HTMLParser):
    """Every start tag with its attributes, and the text outside of scripts and styles."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.text = [], ''
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.tags[-1:] and self.tags[-1][0] not in ('script', 'style'):
            self.text += data


def picture(source):
    return decode(base64.b64decode(source.split(',')[1]))


def trace(figure, name):
    return next(trace for trace in figure.data if trace.name == name)


def test_page_loads_nothing(page):
    tags = Elements(page).tags
    assert not [tag for tag in tags
                if tag[0] in ('link', 'iframe', 'img', 'object', 'embed', 'base')]
    assert not [tag for tag in tags if {'src', 'href'} & tag[1].keys()]
    policy = next(attributes['content'] for _, attributes in tags
                  if attributes.get('http-equiv') == 'Content-Security-Policy')
    assert policy.startswith("default-src 'none'")
    assert 'http' not in policy


def test_page_cannot_send_the_data_away(page):
    assert page.count('"showSendToCloud": false') == 5


def test_nasty_names_stay_text(page):
    assert NASTY not in page
    assert f'Thickness of print {NASTY}' in Elements(page).text
    assert f'{NASTY}.mcap' in Elements(page).text


def test_page_says_the_numbers(page):
    text = Elements(page).text
    for words in ('2.000 mm',
                  'flow x 1.08, or else speed x 0.93: what is laid now comes out too thin',
                  '100.0 %', '1, together 1.0 mm', 'no <deposit>',
                  'advice.dead_band', 'cell.calib', '1970-01-01 00:00:01.000 UTC'):
        assert words in text


def test_page_is_small(page):
    assert len(page.encode()) < 6e6


def test_same_result_same_page(page, result):
    assert page == rendered(result)


def test_page_leafs_through_the_captures(page):
    # Text in a script element; tojson keeps it from ending that.
    frames = json.loads(page.split('id="frames">')[1].split('</script>')[0])
    refused, reported = frames
    assert refused['words'] == 'refused: no <deposit>'
    assert picture(refused['source']).shape == (4 * 24, 4 * 32, 3)
    assert (reported['capture'], reported['source']) == (0, '')
    assert reported['words'] == '2.000 mm ± 0.000 mm, 100.0 % known'


@pytest.mark.parametrize(('valid', 'reason', 'words'), [
    (False, Reason.GAP_DETECTED, 'change nothing: gap detected'),
    (True, Reason.ON_TARGET, 'change nothing: on target'),
    (True, Reason.LIMITED, 'flow x 2.00, or else speed x 0.50: '
                           'limited to the largest change allowed')])
def test_advice_in_words(valid, reason, words):
    advice = RateAdvice(0, '', valid, reason, 1.0, 1.0, (0.0, 1.0), 1, 2.0, 0.5, 1.0, 0.0, 0)
    assert wording.advice_in_words(advice) == words


def test_everything_has_words_and_a_colour_of_its_own():
    assert set(wording.REASONS) == set(Reason)
    assert set(wording.MEANINGS) == set(legend.COLOURS) == set(Status)
    colours = [*legend.COLOURS.values(), legend.LEFT, legend.RIGHT]
    assert len(set(colours)) == len(colours)


def test_points_are_drawn_where_the_camera_sees_them(result):
    # 0.1 m away with f = 100 pixels: 1 mm is 1 pixel; the axis passes at (5, 12).
    figure = figures.image_figure(result)
    gap = trace(figure, 'gap')
    # Half-way to its neighbours, and pen up.
    assert gap.x[:3] == pytest.approx([6.5, 7, 7.5])
    assert gap.y[:3] == pytest.approx([12, 12, 12])
    assert np.isnan(gap.x[3])
    assert gap.line.color == legend.COLOURS[Status.GAP]
    left, right = trace(figure, 'left side'), trace(figure, 'right side')
    np.testing.assert_allclose(left.x[:5], (5, 6, np.nan, 8, 9), rtol=1e-6)
    assert left.y[np.isfinite(left.y)] == pytest.approx(np.full(19, 11.0))
    assert right.y[np.isfinite(right.y)] == pytest.approx(np.full(19, 13.0))
    assert figure.layout.xaxis.range == (-0.5, 31.5)
    assert figure.layout.yaxis.range == (23.5, -0.5)


def test_points_outside_the_image_are_not_drawn(result):
    outside = overlay.path_pixels(result, np.array(((0.0, 0.0, 0.1), (0.1, 0.0, 0.1))))
    np.testing.assert_allclose(outside, ((5, 12), (np.nan, np.nan)))


def test_image_keeps_its_colours(result):
    shown = figures.image_figure(result).layout.images[0]
    assert shown.source.startswith('data:image/jpeg;base64,')
    assert np.abs(picture(shown.source).astype(int) - result.capture.image).max() < 20
    # Pixel centres have integer coordinates.
    assert (shown.x, shown.y, shown.sizex, shown.sizey) == (-0.5, -0.5, 32, 24)


def test_thickness_shows_target_gap_and_window(result):
    figure = figures.thickness_figure(result, TARGETS, 0.03)
    gap = trace(figure, 'gap')
    assert gap.x[:4] == pytest.approx([1.5, 1.5, 2.5, 2.5])
    assert gap.fillcolor == legend.COLOURS[Status.GAP]
    assert trace(figure, 'target').y == pytest.approx([2.078, 2.078])
    assert trace(figure, 'dead band').y[0] == pytest.approx(0.97 * 2.078)
    shapes = {shape.name: shape for shape in figure.layout.shapes}
    assert (shapes['advice window'].x0, shapes['advice window'].x1) == pytest.approx((5, 19))
    line = trace(figure, 'thickness')
    assert line.y[1] == pytest.approx(2)
    assert np.isnan(line.y[2])
    # Two samples before the gap: along the lower border, back along the upper, pen up.
    band = trace(figure, '± 1 sigma')
    np.testing.assert_allclose(band.x[:5], (0, 1, 1, 0, np.nan))
    np.testing.assert_allclose(band.y[:5], (1.9, 1.9, 2.1, 2.1, np.nan), rtol=1e-6)


def test_graded_target_is_drawn_with_its_corners(result):
    graded = WidthTargets(np.array((0.0, 10, 10, 30)) * MM, np.array((1.0, 2, 3, 3)) * MM)
    target = trace(figures.thickness_figure(result, graded, 0.0), 'target')
    assert target.x == pytest.approx([0, 10, 10, 19])
    assert target.y == pytest.approx([1, 2, 3, 3])


def test_offset_is_positive_to_the_left(result):
    shifted = replace(result.profile, left=1.5 * result.profile.left,
                      right=0.5 * result.profile.right)
    offset = trace(figures.offset_figure(shifted), 'offset')
    assert offset.y[0] == pytest.approx(0.5)
    assert np.isnan(offset.y[2])


def test_ribbon_is_as_wide_as_measured_and_coloured_by_deviation(result):
    targets = WidthTargets.constant(2.5 * MM)
    ribbon = trace(figures.map_figure(result.profile, targets), 'measured')
    # Left sides first, then right ones; two triangles from sample to sample, none at the gap.
    assert (ribbon.y[0], ribbon.y[20]) == pytest.approx((-1, 1))
    assert len(ribbon.i) == 2 * 17
    assert {tuple(corners) for corners in zip(ribbon.i, ribbon.j, ribbon.k, strict=True)} >= {
        (0, 20, 1), (20, 21, 1)}
    assert ribbon.intensity[0] == pytest.approx(-20)


def test_long_print_is_thinned_in_3d(result):
    count = 10_000
    x = np.linspace(0, 2, count)
    points = np.column_stack((x, np.zeros(count), np.full(count, 0.1)))
    plain = np.full(count, MM)
    long = replace(result.profile, time=x, arc_length=x, points=points,
                   extruding=np.ones(count, bool), status=np.zeros(count, np.uint8),
                   thickness=2 * plain, sigma=plain, left=plain, right=plain,
                   left_points=points, right_points=points)
    ribbon = trace(figures.map_figure(long, None), 'measured')
    assert 0.4 * figures.MAP_SAMPLES < len(ribbon.x) / 2 <= figures.MAP_SAMPLES


def test_pictures_stay_within_their_budget(result):
    noise = np.random.default_rng(0).integers(0, 256, (24, 32, 3), np.uint8)
    noisy = Result(replace(result.capture, image=noise), refusal='noise')
    assert len(encode(noise, 10**6)[0]) > 600
    for expected in (40, None):
        thumbnails = Thumbnails(expected, budget=12_000)
        for _ in range(40):
            thumbnails.add(noisy)
            assert sum(map(len, thumbnails.pictures.values())) <= 12_000
        assert list(thumbnails.pictures) == list(range(40))
        assert decode(thumbnails.pictures[0]).shape[1] > 10


def test_of_very_many_captures_some_are_pictured(result):
    thumbnails = Thumbnails()
    for _ in range(2 * MOST + 3):
        thumbnails.add(result)
    numbers = list(thumbnails.pictures)
    assert MOST / 2 < len(numbers) <= MOST
    assert numbers[-1] == 2 * MOST + 2
    assert set(np.diff(numbers[:-1])) == {4}


def test_histogram_counts_measured_samples(result):
    figure = figures.histogram_figure(result.profile, TARGETS)
    assert len(figure.data[0].x) == 19
    assert [shape.name for shape in figure.layout.shapes] == [
        'first quartile 2.000 mm', 'median 2.000 mm', 'third quartile 2.000 mm',
        'target 2.078 mm']
