"""Every setting is described, and values that do not fit together are refused."""

from __future__ import annotations

from typing import Any

import pytest

from bpc_perception.core.config import (
    AdviceConfig,
    CameraConfig,
    PathConfig,
    RecorderConfig,
    SegmentationConfig,
    ThicknessConfig,
)
from bpc_perception.core.parameter import (
    Config,
    ConfigError,
    flatten,
    parameters_of,
    replace_flat,
)

ROOTS = (ThicknessConfig(), RecorderConfig(), CameraConfig())
ALL = [(root, name, parameter, value)
       for root in ROOTS for name, parameter, value in flatten(root)]


def name_of(row: Any) -> str:
    return row[1] if isinstance(row, tuple) else ''


@pytest.mark.parametrize('row', ALL, ids=name_of)
def test_every_parameter_is_described(row: Any) -> None:
    assert len(row[2].description) > 10


@pytest.mark.parametrize('config_type', [
    SegmentationConfig, AdviceConfig, PathConfig, RecorderConfig,
    ThicknessConfig, CameraConfig], ids=lambda kind: kind.__name__)
def test_no_field_goes_without_parameter(config_type: type[Config]) -> None:
    described = parameters_of(config_type)
    for name, field in config_type.__dataclass_fields__.items():
        assert name in described or isinstance(getattr(config_type(), name), Config), field


@pytest.mark.parametrize('size', [2, 100])
def test_an_even_kernel_is_refused(size: int) -> None:
    with pytest.raises(ConfigError, match=f'^kernel_size: expected an odd number, found {size}'):
        SegmentationConfig(kernel_size=size)


def test_canny_thresholds_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(ConfigError,
                       match=r'^segmentation.canny_low: expected at most .*150.*, found 151'):
        replace_flat(ThicknessConfig(), {'segmentation.canny_low': 151.0})


def test_equal_canny_thresholds_are_allowed() -> None:
    assert SegmentationConfig(canny_low=150.0).canny_low == 150.0


def test_two_values_that_only_fit_together_can_be_set_together() -> None:
    config = replace_flat(ThicknessConfig(), {'segmentation.canny_low': 200.0,
                                              'segmentation.canny_high': 300.0})
    assert (config.segmentation.canny_low, config.segmentation.canny_high) == (200.0, 300.0)
