"""The report: carries everything it shows, says it in words, and draws where things are."""

import base64
from html.parser import HTMLParser

from bpc_perception.core.advice import RateAdvice, Reason
from bpc_perception.core.capture import Capture, PinholeCamera
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.session import Result
from bpc_perception.outputs import Provenance, summarize
import cv2
import numpy as np
import pytest

from bpc_perception import legend, overlay, report

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


@pytest.fixture
def page(result):
    refused = Result(result.capture, refusal='no <deposit>')
    return report.render(result, summarize([refused, result], Provenance(
        f'{NASTY}.mcap', 'cell.calib', {'advice.dead_band': 0.03}, {'bpc': '0.1.0'})))


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
    assert page.count('"showSendToCloud": false') == 3


def test_nasty_names_stay_text(page):
    assert NASTY not in page
    assert f'Thickness of print {NASTY}' in Elements(page).text
    assert f'{NASTY}.mcap' in Elements(page).text


def test_page_says_the_numbers(page):
    text = Elements(page).text
    for words in ('2.000 mm', 'flow x 1.08, or else speed x 0.93: the filament is too thin',
                  '100.0 %', '1, together 1.0 mm', 'no <deposit>',
                  'advice.dead_band', 'cell.calib', '1970-01-01 00:00:01.000 UTC'):
        assert words in text


def test_page_is_small(page):
    assert len(page.encode()) < 6e6


def test_same_result_same_page(page, result):
    refused = Result(result.capture, refusal='no <deposit>')
    again = report.render(result, summarize([refused, result], Provenance(
        f'{NASTY}.mcap', 'cell.calib', {'advice.dead_band': 0.03}, {'bpc': '0.1.0'})))
    assert page == again


@pytest.mark.parametrize(('valid', 'reason', 'words'), [
    (False, Reason.GAP_DETECTED, 'change nothing: gap detected'),
    (True, Reason.ON_TARGET, 'change nothing: on target'),
    (True, Reason.LIMITED, 'flow x 2.00, or else speed x 0.50: '
                           'limited to the largest change allowed')])
def test_advice_in_words(valid, reason, words):
    advice = RateAdvice(0, '', valid, reason, 1.0, 1.0, (0.0, 1.0), 1, 2.0, 0.5, 1.0, 0.0, 0)
    assert legend.advice_in_words(advice) == words


def test_everything_has_words_and_a_colour_of_its_own():
    assert set(legend.REASONS) == set(Reason)
    assert set(legend.MEANINGS) == set(legend.COLOURS) == set(Status)
    colours = [*legend.COLOURS.values(), legend.LEFT, legend.RIGHT]
    assert len(set(colours)) == len(colours)


def test_points_are_drawn_where_the_camera_sees_them(result):
    # 0.1 m away with f = 100 pixels: 1 mm is 1 pixel; the axis passes at (5, 12).
    figure = report.image_figure(result)
    gap = trace(figure, 'gap')
    assert (list(gap.x), list(gap.y)) == (pytest.approx([7]), pytest.approx([12]))
    assert gap.marker.color == legend.COLOURS[Status.GAP]
    left, right = trace(figure, 'left side'), trace(figure, 'right side')
    assert left.x[:3] == pytest.approx([5, 6, 8])
    assert left.y == pytest.approx(np.full(19, 11.0))
    assert right.y == pytest.approx(np.full(19, 13.0))
    assert figure.layout.xaxis.range == (-0.5, 31.5)
    assert figure.layout.yaxis.range == (23.5, -0.5)


def test_points_outside_the_image_are_not_drawn(result):
    outside = overlay.path_pixels(result, np.array(((0.0, 0.0, 0.1), (0.1, 0.0, 0.1))))
    np.testing.assert_allclose(outside, ((5, 12), (np.nan, np.nan)))


def test_image_keeps_its_colours(result):
    source = report.image_figure(result).data[0].source
    header, data = source.split(',')
    assert header == 'data:image/jpeg;base64'
    decoded = cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(decoded[:, :, ::-1].astype(int) - result.capture.image).max() < 20


def test_thickness_shows_target_gap_and_window(result):
    path = overlay.path_pixels(result, result.profile.points)
    figure = report.thickness_figure(result.profile, result.advice, path, 0.03)
    shapes = {shape.name: shape for shape in figure.layout.shapes}
    assert (shapes['gap'].x0, shapes['gap'].x1) == pytest.approx((1.5, 2.5))
    assert shapes['gap'].fillcolor == legend.COLOURS[Status.GAP]
    assert shapes['target'].y0 == pytest.approx(2.078)
    assert shapes['dead band'].y0 == pytest.approx(0.97 * 2.078)
    assert (shapes['advice window'].x0, shapes['advice window'].x1) == pytest.approx((5, 19))
    line = trace(figure, 'thickness')
    assert line.y[1] == pytest.approx(2)
    assert np.isnan(line.y[2])
    # Two samples before the gap: along the lower border, back along the upper, pen up.
    band = trace(figure, '± 1 sigma')
    np.testing.assert_allclose(band.x[:5], (0, 1, 1, 0, np.nan))
    np.testing.assert_allclose(band.y[:5], (1.9, 1.9, 2.1, 2.1, np.nan))


def test_histogram_counts_measured_samples(result):
    figure = report.histogram_figure(result.profile, result.advice)
    assert len(figure.data[0].x) == 19
    assert [shape.name for shape in figure.layout.shapes] == [
        'first quartile 2.000 mm', 'median 2.000 mm', 'third quartile 2.000 mm',
        'target 2.078 mm']
