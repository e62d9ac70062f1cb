"""Strokes in layers, compared with layers_thresholds.yaml; `bpc study layers` has more prints."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from bpc_perception.core.profile import Status
from bpc_perception.core.testprints.setup import Setup
from bpc_perception.core.testprints.stacked import wall
from bpc_sim.ink.extrusion import ExtruderBehaviour
from bpc_sim.printer.design_job import design_job
from bpc_sim.scene.surfaces import Cylinder
from bpc_sim.studies import Row
from bpc_sim.studies.layers_study import (
    compare_layers,
    compare_sizes,
    measure_job,
    measure_print,
    print_job,
    rows,
    TRANSLUCENT,
    true_arc,
)

THRESHOLDS = yaml.safe_load(
    Path(__file__).with_name('layers_thresholds.yaml').read_text(encoding='utf-8'))
PRINTS = THRESHOLDS['prints']
pytestmark = [pytest.mark.accuracy, pytest.mark.timeout(600)]


@pytest.fixture(scope='module')
def table() -> list[Row]:
    """A row for each layer of each print."""
    tasks = [(name, float(tilt), 0) for name, print_ in PRINTS.items()
             for tilt in print_['tilts']]
    return rows([measure_print(task) for task in tasks])


def test_every_layer_is_there(table: list[Row]) -> None:
    assert [(row['scene'], row['layer']) for row in table] == [
        (name, layer) for name in PRINTS for layer in range(3 if name == 'stack' else 4)]


@pytest.mark.parametrize('name', list(PRINTS))
def test_each_layer_is_measured_as_it_is(name: str, table: list[Row]) -> None:
    missed = [row for row in table if row['scene'] == name and not (
        row['answered'] >= PRINTS[name]['answered'] and row['MAE_mm'] <= PRINTS[name]['MAE_mm']
        and row['wrong'] <= THRESHOLDS['wrong'])]
    assert missed == []


@pytest.mark.parametrize('name', list(PRINTS))
def test_height_area_and_volume_are_those_of_the_ink(name: str, table: list[Row]) -> None:
    height = THRESHOLDS['height_MAE_mm']
    missed = [row for row in table if row['scene'] == name and not (
        row['sized'] >= THRESHOLDS['sized']
        and row['height_MAE_mm'] <= (height['on_ink'] if row['layer'] else height['on_bed'])
        and row['area_error'] <= THRESHOLDS['area_error']
        and row['volume_error'] <= PRINTS[name]['volume_error'])]
    assert missed == []


@pytest.mark.parametrize('of', ['', 'height_', 'area_'])
def test_a_sigma_says_how_far_off_a_number_may_be(of: str, table: list[Row]) -> None:
    missed = [row for row in table
              if not (row[f'{of}within_1_sigma'] >= THRESHOLDS['within_1_sigma']
                      and row[f'{of}within_2_sigma'] >= THRESHOLDS['within_2_sigma'])]
    assert missed == []


@pytest.mark.parametrize(('name', 'layer', 'share'), [
    ('stack', 1, 0.75), ('stack', 2, 0.85), ('lattice', 3, 0.75)])
def test_a_strand_narrower_than_that_below_is_told_as_narrow(
        name: str, layer: int, share: float) -> None:
    """The edge in the picture is that of the ink below."""
    job = print_job(name, 0.0, 1)
    begin, end = job.layers[layer]
    width = job.commanded.profile
    job = replace(job, printed_width=lambda s: width(s) * np.where(
        (s > begin) & (s < end), share, 1.0))
    found = compare_layers(job, measure_job(job))[layer]
    true = share * found.true
    error = (found.thickness - true)[found.status == Status.MEASURED]
    sigma = found.sigma[found.status == Status.MEASURED]
    assert len(error) > 0.9 * len(true)
    assert np.abs(error).mean() < 0.06e-3
    assert np.mean(np.abs(error) > 3 * sigma) < 0.03


def test_of_ink_that_light_goes_into_widths_are_told_and_no_heights() -> None:
    """Its points lie too deep: how deep, the ink on the bed tells."""
    for row in rows([measure_print((TRANSLUCENT, 0.0, 0))]):
        assert row['height_fair'] >= THRESHOLDS['height_fair']
        assert row['sized'] == 0
        assert row['wrong'] <= THRESHOLDS['wrong']
        assert row['answered'] >= PRINTS['stack']['answered']
        assert row['MAE_mm'] <= PRINTS['stack']['MAE_mm']
        assert row['within_2_sigma'] >= THRESHOLDS['within_2_sigma']


@pytest.mark.parametrize(('name', 'stroke', 'length'), [
    ('stack', 5, 6e-3), ('stack', 8, 4e-3), ('wall', 3, 6e-3), ('lattice', 7, 6e-3),
    ('lattice', 18, 3e-3)])
def test_a_gap_on_ink_is_one(name: str, stroke: int, length: float) -> None:
    """Colour does not tell it, nor do widths: below is ink that is as wide, or a pore."""
    job = print_job(name, 25.0, 0)  # the nozzle, which waits, is not in front of it
    start, end = job.commanded.runs[stroke - 1]
    begin = (start + end - length) / 2
    job = replace(job, faults=np.array(((begin, begin + length),)))
    profile = measure_job(job)
    arc, laid = true_arc(job, profile), profile.stroke > 0
    # The ink ends round.
    inside = laid & (arc > begin + 1e-3) & (arc < begin + length - 1e-3)
    outside = laid & ((arc < begin - 1e-3) | (arc > begin + length + 1e-3))
    assert (profile.status[inside] == Status.GAP).mean() > 0.9
    assert not (profile.status[inside] == Status.MEASURED).any()
    assert not (profile.status[outside] == Status.GAP).any()
    assert (profile.status[outside] == Status.MEASURED).mean() > 0.95


def test_after_a_first_layer_that_nobody_saw_those_above_are_measured() -> None:
    """So it is when a node is started again amid a print."""
    job = print_job('stack', 25.0, 0)
    profile = measure_job(job, missed=8)
    first, _, third = compare_layers(job, profile)
    assert (first.status == Status.OCCLUDED).all()
    assert (third.status == Status.MEASURED).mean() > 0.95
    assert np.nanmean(np.abs(third.thickness - third.true)) < 6e-5


def test_layers_on_a_bed_that_bends_much_are_measured_as_they_are() -> None:
    """The bed is higher below a bead than between its sides, and lies otherwise at each stroke."""
    job = replace(print_job('stack', 0.0, 0), surface=Cylinder(0.04))
    for layer in compare_layers(job, measure_job(job)):
        assert (layer.status == Status.MEASURED).mean() > 0.95
        assert np.nanmean(np.abs(layer.thickness - layer.true)) < 6e-5


def test_ink_beside_a_bead_that_lies_on_ink_is_not_of_it() -> None:
    """A wall of alike layers: the area of each is that of its ink, by geometry.

    At six pixels a bead, seen aslant, points of what lies below seem to be on its flanks.
    """
    test = wall(Setup(0.8e-3, (80e-3, 80e-3)), layers=4)
    shares = []
    for seed in range(8):
        ink = ExtruderBehaviour(lag=0.05, noise=0.02, seed=seed)
        job = replace(design_job(test.design, test.plans, ink), seed=seed)
        sizes = compare_sizes(job, measure_job(job))
        shares.append([float(np.mean(one.area[0] / one.area[2])) for one in sizes])
    above = np.array(shares)[:, 1:] - 1
    assert np.abs(above.mean(axis=0)).max() < 0.05
    assert np.sqrt((above**2).mean()) < 0.055
