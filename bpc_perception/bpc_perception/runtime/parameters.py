"""Make ROS parameters of configuration objects, which hold their defaults and limits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from bpc_perception.core.parameter import ConfigError, ConfigType, flatten, Parameter, replace_flat


class NodeConfig(Generic[ConfigType]):
    """A configuration object that follows the parameters of its node.

    It declares a parameter for each field. Values that do not fit are refused with the reason: at
    the start with ConfigError, later in the answer to the request that sets them.

    Args:
        node: the node whose parameters are declared.
        default: the configuration with the default values.
        on_change: gets each new configuration.

    Attributes:
        value: the current configuration.
    """

    def __init__(self, node: Node, default: ConfigType,
                 on_change: Callable[[ConfigType], None] = lambda _: None) -> None:
        self._on_change = on_change
        self._names = [name for name, _, _ in flatten(default)]
        values = {}
        for name, parameter, value in flatten(default):
            descriptor = _descriptor(parameter, value)
            start = list(value) if isinstance(value, tuple) else value
            try:
                values[name] = node.declare_parameter(name, start, descriptor).value
            except ParameterException as error:
                raise ConfigError(str(error)) from error
        self.value: ConfigType = replace_flat(default, _plain(values))
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._follow)

    def _changed(self, parameters: list[RosParameter]) -> ConfigType:
        changes = {p.name: p.value for p in parameters if p.name in self._names}
        return replace_flat(self.value, _plain(changes))

    def _check(self, parameters: list[RosParameter]) -> SetParametersResult:
        try:
            self._changed(parameters)
        except ConfigError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _follow(self, parameters: list[RosParameter]) -> None:
        if any(p.name in self._names for p in parameters):
            self.value = self._changed(parameters)
            self._on_change(self.value)


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    """Convert arrays to tuples, as configuration objects hold them."""
    return {name: value if isinstance(value, str | bool | int | float) else tuple(value)
            for name, value in values.items()}


def _descriptor(parameter: Parameter, value: Any) -> ParameterDescriptor:
    unit = f' [{parameter.unit}]' if parameter.unit else ''
    choices = f'; one of {", ".join(parameter.choices)}' if parameter.choices else ''
    descriptor = ParameterDescriptor(description=f'{parameter.description}{unit}{choices}',
                                     read_only=parameter.read_only)
    low, high = parameter.minimum, parameter.maximum
    if low is None or high is None or isinstance(value, bool):
        return descriptor
    if isinstance(value, int):
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
    elif isinstance(value, float):
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high))]
    return descriptor
