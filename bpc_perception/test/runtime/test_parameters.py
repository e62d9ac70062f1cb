"""Parameters of a node: their limits, and which values are refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bpc_perception.core.parameter import ConfigError

pytest.importorskip('rclpy')
from node_builders import thickness_bench
from rclpy.parameter import Parameter

pytestmark = pytest.mark.ros


@pytest.mark.parametrize(('name', 'value', 'reason'), [
    ('advice.target_thickness', 5.0, 'advice.target_thickness'),
    ('advice.target_thickness', 'wide', 'DOUBLE'),
    ('advice.target_thickness', float('nan'), 'advice.target_thickness'),
    ('segmentation.kernel_size', 4, 'odd'),
    ('segmentation.canny_low', 200.0, 'canny_high'),
    ('method', 'guess', 'paper'),
    ('base_frame', 'world', 'read-only'),
])
def test_a_bad_parameter_is_refused_at_run_time_with_the_reason(
        graph: Any, tmp_path: Path, name: str, value: Any, reason: str) -> None:
    bench = thickness_bench(graph, tmp_path)
    before = bench.node.get_parameter(name).value
    result, = bench.node.set_parameters([Parameter(name, value=value)])
    assert not result.successful
    assert reason in result.reason
    assert bench.node.get_parameter(name).value == before


def test_values_that_only_fit_together_can_be_set_together(graph: Any, tmp_path: Path) -> None:
    node = thickness_bench(graph, tmp_path).node
    result = node.set_parameters_atomically([Parameter('segmentation.canny_low', value=200.0),
                                             Parameter('segmentation.canny_high', value=300.0)])
    assert result.successful


@pytest.mark.parametrize(('name', 'value'), [
    ('patience', -1.0), ('patience', 'long'), ('patience', float('nan')),
    ('advice__minimum_samples', 0), ('segmentation__kernel_size', 4), ('method', 'guess')])
def test_a_bad_parameter_is_refused_at_the_start(graph: Any, tmp_path: Path, name: str,
                                                 value: Any) -> None:
    with pytest.raises(ConfigError, match=name.split('__')[-1]):
        thickness_bench(graph, tmp_path, **{name: value})


def test_every_parameter_has_a_description_and_limits(graph: Any, tmp_path: Path) -> None:
    node = thickness_bench(graph, tmp_path).node
    descriptor = node.describe_parameter('advice.target_thickness')
    assert 'Thickness wanted' in descriptor.description
    assert '[m]' in descriptor.description
    assert descriptor.floating_point_range[0].to_value == 0.1
    assert node.describe_parameter('segmentation.kernel_size').integer_range[0].from_value == 1
    assert node.describe_parameter('base_frame').read_only
