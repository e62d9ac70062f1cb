"""Configuration objects refuse what does not fit, and say why."""

from __future__ import annotations

from typing import Any

import pytest

from bpc_perception.core.config import CameraConfig, RecorderConfig, ThicknessConfig
from bpc_perception.core.parameter import ConfigError, flatten, Parameter, replace_flat

ROOTS = (ThicknessConfig(), RecorderConfig(), CameraConfig())
ALL = [(root, name, parameter, value)
       for root in ROOTS for name, parameter, value in flatten(root)]
LIMITED = [row for row in ALL if row[2].minimum is not None and type(row[3]) in (int, float)]


def name_of(row: Any) -> str:
    return row[1] if isinstance(row, tuple) else ''


def another(parameter: Parameter, value: Any) -> Any:
    """A value that is allowed and not the default."""
    if parameter.choices:
        return next((choice for choice in parameter.choices if choice != value), None)
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return f'{value}x'
    if isinstance(value, tuple):
        return tuple(item + (1 if isinstance(item, int) else 0.1) for item in value)
    assert parameter.minimum is not None
    assert parameter.maximum is not None
    if isinstance(value, int):
        return value + 2
    return value * 1.01 + 1e-3 if value * 1.01 + 1e-3 <= parameter.maximum else value * 0.99


@pytest.mark.parametrize('row', ALL, ids=name_of)
def test_each_parameter_changes_its_field_alone(row: Any) -> None:
    root, name, parameter, value = row
    wanted = another(parameter, value)
    if wanted is None:
        pytest.skip('has one choice only')
    before = {key: current for key, _, current in flatten(root)}
    after = {key: current for key, _, current in flatten(replace_flat(root, {name: wanted}))}
    assert after == {**before, name: wanted}
    assert wanted != value


@pytest.mark.parametrize('row', LIMITED, ids=name_of)
def test_numbers_outside_their_limits_are_refused(row: Any) -> None:
    root, name, parameter, value = row
    for wrong in (parameter.minimum - 1, parameter.maximum + 1):
        wrong = type(value)(wrong)
        with pytest.raises(ConfigError, match=rf'^{name}: expected .* to .*, found {wrong}$'):
            replace_flat(root, {name: wrong})


@pytest.mark.parametrize('row', LIMITED, ids=name_of)
def test_limits_themselves_are_allowed(row: Any) -> None:
    _, name, parameter, value = row
    kind = type(value)
    parameter.check(name, kind(parameter.minimum), kind)
    parameter.check(name, kind(parameter.maximum), kind)


@pytest.mark.parametrize('row', [row for row in LIMITED if isinstance(row[3], float)],
                         ids=name_of)
@pytest.mark.parametrize('wrong', [float('nan'), float('inf'), -float('inf')])
def test_numbers_that_are_not_finite_are_refused(row: Any, wrong: float) -> None:
    with pytest.raises(ConfigError, match=r'expected .* found (nan|inf|-inf)$'):
        replace_flat(row[0], {row[1]: wrong})


@pytest.mark.parametrize(('root', 'name', 'wrong', 'expected'), [
    (ThicknessConfig(), 'patience', '1', 'a float'),
    (ThicknessConfig(), 'patience', True, 'a float'),
    (ThicknessConfig(), 'patience', None, 'a float'),
    (ThicknessConfig(), 'segmentation.kernel_size', 3.0, 'a int'),
    (ThicknessConfig(), 'segmentation.kernel_size', False, 'a int'),
    (ThicknessConfig(), 'base_frame', 1, 'a str'),
    (ThicknessConfig(), 'method', 'guess', 'one of .*paper'),
    (RecorderConfig(), 'path.auto', 1, 'a bool'),
    (RecorderConfig(), 'nozzle_offset', (0.0, 0.0), '3 numbers'),
    (RecorderConfig(), 'nozzle_offset', 0.0, '3 numbers'),
    (RecorderConfig(), 'nozzle_offset', (0.0, 0.0, 'up'), 'a float'),
    (RecorderConfig(), 'nozzle_offset', (0.0, 0.0, 9.0), '-2 to 2'),
])
def test_wrong_values_are_refused_naming_both(root: Any, name: str, wrong: object,
                                              expected: str) -> None:
    with pytest.raises(ConfigError, match=rf'^{name}: expected {expected}.*, found '):
        replace_flat(root, {name: wrong})


def test_a_whole_number_will_do_for_a_float() -> None:
    value = replace_flat(ThicknessConfig(), {'patience': 3}).patience
    assert value == 3.0
    assert isinstance(value, float)


def test_a_list_will_do_for_a_tuple() -> None:
    config = replace_flat(RecorderConfig(), {'nozzle_offset': [0.0, 0.1, 0.2]})
    assert config.nozzle_offset == (0.0, 0.1, 0.2)


def test_unknown_names_are_refused_naming_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r'^advice.taget: no such .*advice.target_thickness'):
        replace_flat(ThicknessConfig(), {'advice.taget': 0.002})


def test_the_original_is_left_as_it_is() -> None:
    original = ThicknessConfig()
    replace_flat(original, {'advice.target_thickness': 0.002})
    assert original == ThicknessConfig()
