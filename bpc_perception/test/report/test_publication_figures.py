"""Figures for papers: sizes in millimetres, fonts embedded, the same file each time."""

from dataclasses import replace
import re

import numpy as np
from perception_builders import band_image, capture_of, DOWN, profile_of
import pytest

from bpc_perception.core.profile import Status
from bpc_perception.core.result import Result
from bpc_perception.core.targets import WidthTargets
from bpc_perception.report import publication_figures

MM = 1e-3
NAMES = ('overlay', 'thickness', 'offset', 'map', 'histogram')


@pytest.fixture(scope='module')
def result():
    """A straight print of ten samples seen from above; the third is a gap."""
    status = [Status.MEASURED] * 10
    status[2] = Status.GAP
    widths = np.where(np.array(status) == Status.GAP, 0.0, 2 * MM)
    return Result(capture_of(band_image()), DOWN, profile_of(widths.tolist(), status))


@pytest.fixture(scope='module')
def files(result):
    return publication_figures.draw_figures(result, WidthTargets.constant(2 * MM))


def test_every_figure_is_there_in_both_kinds(files):
    assert set(files) == {f'{name}.{kind}' for name in NAMES for kind in ('pdf', 'svg')}


@pytest.mark.parametrize('name', NAMES)
def test_figures_are_as_wide_as_a_column(files, name):
    points = float(re.search(rb'/MediaBox \[ 0 0 ([\d.]+) ', files[f'{name}.pdf'])[1])
    assert points / 72 * 25.4 == pytest.approx(85)
    points = float(re.search(rb'<svg [^>]*width="([\d.]+)pt"', files[f'{name}.svg'])[1])
    assert points / 72 * 25.4 == pytest.approx(85)


@pytest.mark.parametrize('name', NAMES)
def test_nothing_is_needed_from_elsewhere(files, name):
    # Each font of a PDF is embedded; an SVG has outlines instead of letters.
    text = files[f'{name}.pdf']
    assert text.count(b'/FontFile2') == text.count(b'/Type /FontDescriptor') > 0
    drawing = files[f'{name}.svg']
    assert b'<text' not in drawing
    addresses = set(re.findall(rb'href="([^"#]{1,40})', drawing))
    assert all(address.startswith(b'data:') for address in addresses)


def test_lines_are_lines(files):
    # Only the overlay contains pixels in the PDF.
    for name in NAMES:
        assert (b'/Subtype /Image' in files[f'{name}.pdf']) == (name == 'overlay')


def test_colours_are_those_of_the_legend(files):
    drawing = files['offset.svg'].decode().lower()
    assert '#0072b2' in drawing
    assert '#d55e00' in drawing  # the gap


def test_the_same_result_gives_the_same_files(result, files):
    assert publication_figures.draw_figures(result, WidthTargets.constant(2 * MM)) == files


def test_a_print_in_layers_has_overlay_and_map_of_each(result):
    layered = replace(result, profile=replace(
        result.profile, layer=np.repeat((0, 1), 5), stroke=np.repeat((1, 2), 5)))
    files = publication_figures.draw_figures(layered, None)
    assert {name.partition('.')[0] for name in files} == {
        'thickness', 'offset', 'histogram', 'overlay_layer_0', 'overlay_layer_1', 'map_layer_0',
        'map_layer_1'}
    # The gap is in the first layer.
    gap = b'#d55e00'
    assert gap in files['overlay_layer_0.svg'].lower()
    assert gap not in files['overlay_layer_1.svg'].lower()


def test_nothing_measured_can_be_drawn():
    blind = Result(capture_of(band_image()), DOWN, profile_of(
        [np.nan] * 4, [Status.NO_DATA] * 4))
    assert set(publication_figures.draw_figures(blind, None)) >= {'map.pdf', 'histogram.svg'}
