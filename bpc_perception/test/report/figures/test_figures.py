"""Where things are drawn in the figures of the report, and how."""

import base64
from dataclasses import replace

import numpy as np
from perception_builders import on_one_layer
import plotly.graph_objects as go
import plotly.io
import pytest

from bpc_perception.core.profile import Status
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.legend import STATUS_COLOURS
from bpc_perception.report.figures import deviation_map, histogram, image, offset, thickness
from bpc_perception.report.figures.deviation_map import MOST_SAMPLES
from bpc_perception.report.figures.figure import Figure, typed_array
from bpc_perception.report.thumbnails import decode

MM = 1e-3
TARGETS = WidthTargets.constant(2.078 * MM)


def checked(figure):
    """Return a figure as plotly's own, which refuses what it does not know."""
    return go.Figure(figure.traces, figure.layout)


def image_figure(*what):
    return checked(image.image_figure(*what))


def thickness_figure(*what):
    return checked(thickness.thickness_figure(*what))


def offset_figure(*what):
    return checked(offset.offset_figure(*what))


def map_figure(*what):
    return checked(deviation_map.map_figure(*what))


def histogram_figure(*what):
    return checked(histogram.histogram_figure(*what))


def picture(source):
    return decode(base64.b64decode(source.split(',')[1]))


def trace(figure, name):
    return next(trace for trace in figure.data if trace.name == name)


def test_points_are_drawn_where_the_camera_sees_them(result):
    # 0.1 m away with f = 100 pixels: 1 mm is 1 pixel; the axis passes at (5, 12).
    figure = image_figure(result)
    gap = trace(figure, 'gap')
    # Half-way to its neighbours, and pen up.
    assert gap.x[:3] == pytest.approx([6.5, 7, 7.5])
    assert gap.y[:3] == pytest.approx([12, 12, 12])
    assert np.isnan(gap.x[3])
    assert gap.line.color == STATUS_COLOURS[Status.GAP]
    left, right = trace(figure, 'left side'), trace(figure, 'right side')
    np.testing.assert_allclose(left.x[:5], (5, 6, np.nan, 8, 9), rtol=1e-6)
    assert left.y[np.isfinite(left.y)] == pytest.approx(np.full(19, 11.0))
    assert right.y[np.isfinite(right.y)] == pytest.approx(np.full(19, 13.0))
    assert figure.layout.xaxis.range == (-0.5, 31.5)
    assert figure.layout.yaxis.range == (23.5, -0.5)


def test_image_keeps_its_colours(result):
    shown = image_figure(result).layout.images[0]
    assert shown.source.startswith('data:image/jpeg;base64,')
    assert np.abs(picture(shown.source).astype(int) - result.capture.image).max() < 20
    # Pixel centres have integer coordinates.
    assert (shown.x, shown.y, shown.sizex, shown.sizey) == (-0.5, -0.5, 32, 24)


def test_thickness_shows_target_gap_and_window(result):
    figure = thickness_figure(result, TARGETS, 0.03)
    gap = trace(figure, 'gap')
    assert gap.x[:4] == pytest.approx([1.5, 1.5, 2.5, 2.5])
    assert gap.fillcolor == STATUS_COLOURS[Status.GAP]
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
    target = trace(thickness_figure(result, graded, 0.0), 'target')
    assert target.x == pytest.approx([0, 10, 10, 19])
    assert target.y == pytest.approx([1, 2, 3, 3])


def test_offset_is_positive_to_the_left(result):
    shifted = replace(result.profile, left=1.5 * result.profile.left,
                      right=0.5 * result.profile.right)
    offset = trace(offset_figure(shifted), 'offset')
    assert offset.y[0] == pytest.approx(0.5)
    assert np.isnan(offset.y[2])


def test_ribbon_is_as_wide_as_measured_and_coloured_by_deviation(result):
    targets = WidthTargets.constant(2.5 * MM)
    ribbon = trace(map_figure(result.profile, targets), 'measured')
    # Left sides first, then right ones; two triangles from sample to sample, none at the gap.
    assert (ribbon.y[0], ribbon.y[20]) == pytest.approx((-1, 1))
    assert len(ribbon.i) == 2 * 17
    assert {tuple(corners) for corners in zip(ribbon.i, ribbon.j, ribbon.k, strict=True)} >= {
        (0, 20, 1), (20, 21, 1)}
    assert ribbon.intensity[0] == pytest.approx(-20)


def test_a_map_shows_no_travel_and_no_line_out_of_the_picture(result):
    profile = result.profile
    # The last three: one on travel, two on a stroke.
    away = np.arange(len(profile)) >= len(profile) - 3
    status = np.where(away, Status.NO_DATA, profile.status).astype(np.uint8)
    stroke = np.append(np.ones(len(profile) - 3, np.intp), (0, 2, 2))
    points = profile.points + np.outer(away, (1.0, 0, 0))
    figure = map_figure(replace(profile, status=status, stroke=stroke, points=points), None)
    assert {trace.name for trace in figure.data} == {'measured', 'gap'}
    kept = map_figure(result.profile, None).layout.scene.aspectratio
    ratio = figure.layout.scene.aspectratio
    assert ratio.x / ratio.y == pytest.approx(kept.x / kept.y, rel=0.3)


def test_long_print_is_thinned_in_3d(result):
    count = 10_000
    x = np.linspace(0, 2, count)
    points = np.column_stack((x, np.zeros(count), np.full(count, 0.1)))
    plain = np.full(count, MM)
    long = replace(result.profile, time=x, arc_length=x, points=points,
                   extruding=np.ones(count, bool), extruder_known=np.ones(count, bool),
                   stroke=np.ones(count, np.intp), status=np.zeros(count, np.uint8),
                   thickness=2 * plain, sigma=plain, left=plain, right=plain,
                   left_points=points, right_points=points, **on_one_layer(count))
    ribbon = trace(map_figure(long, None), 'measured')
    assert 0.4 * MOST_SAMPLES < len(ribbon.x) / 2 <= MOST_SAMPLES


def test_histogram_counts_measured_samples(result):
    figure = histogram_figure(result.profile, TARGETS)
    assert len(figure.data[0].x) == 19
    assert [shape.name for shape in figure.layout.shapes] == [
        'first quartile 2.000 mm', 'median 2.000 mm', 'third quartile 2.000 mm',
        'target 2.078 mm']


def test_what_is_drawn_says_of_which_layer_it_is(result):
    """So that the page can show one of them; travel goes with the layer before."""
    layer = np.repeat((0, 1), 10)
    layer[9] = -1
    layered = replace(result.profile, layer=layer)
    figure = image_figure(replace(result, profile=layered))
    traces = [trace for trace in figure.data if trace.meta]
    assert {trace.meta['layer'] for trace in traces} == {0, 1}
    names = [trace.name for trace in traces if trace.showlegend]
    assert len(names) == len(set(names)) == len({trace.name for trace in traces})
    ribbons = [trace for trace in map_figure(layered, None).data if trace.name == 'measured']
    assert [trace.meta['layer'] for trace in ribbons] == [0, 1]
    # The bar of colours is there whichever layer is shown.
    assert {trace.coloraxis for trace in ribbons} == {'coloraxis'}


def test_height_is_a_second_curve_where_it_is_known(result):
    assert 'height' not in {trace.name for trace in thickness_figure(result, None, 0.0).data}
    height = np.full(len(result.profile), 0.6 * MM)
    known = replace(result.profile, height=height, height_sigma=height / 60)
    drawn = trace(thickness_figure(replace(result, profile=known), None, 0.0), 'height')
    np.testing.assert_allclose(drawn.y, 0.6, rtol=1e-6)


def test_template_is_that_of_plotly():
    assert Figure().layout['template'] == plotly.io.templates['plotly_white'].to_plotly_json()


def test_arrays_are_written_as_plotly_writes_them():
    arrays = {'x': np.array((1.5, np.nan), np.float32), 'y': np.array((1, 70_000), np.int32),
              'customdata': np.arange(6, dtype=np.float32).reshape(2, 3).T, 'text': np.empty(0)}
    written = go.Figure([{'type': 'scatter', **arrays}]).to_dict()['data'][0]
    for name, values in arrays.items():
        assert typed_array(values) == (written[name] if len(values) else [])
