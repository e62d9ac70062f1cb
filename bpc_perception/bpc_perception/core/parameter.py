"""Described, validated, frozen fields: what every configuration object is made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
import math
from typing import Any, get_args, get_origin, get_type_hints, TypeVar

ConfigType = TypeVar('ConfigType', bound='Config')


class ConfigError(ValueError):
    """A configuration value is not what was expected; the message names both."""


@dataclass(frozen=True)
class Parameter:
    """What a configuration field means and which values it takes."""

    description: str
    unit: str = ''
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = False

    def check(self, name: str, value: object, kind: Any) -> None:
        """Raise ConfigError unless ``value`` is a ``kind`` within the limits."""
        if get_origin(kind) is tuple:
            self._check_items(name, value, get_args(kind))
            return
        accepted: tuple[type, ...] = (int, float) if kind is float else (kind,)
        if not isinstance(value, accepted) or (isinstance(value, bool) and kind is not bool):
            raise ConfigError(f'{name}: expected a {kind.__name__}, found {value!r}')
        if self.choices and value not in self.choices:
            raise ConfigError(
                f'{name}: expected one of {", ".join(self.choices)}, found {value!r}')
        if isinstance(value, int | float) and not isinstance(value, bool):
            self._check_limits(name, value)

    def _check_items(self, name: str, value: object, kinds: tuple[Any, ...]) -> None:
        if not isinstance(value, tuple) or len(value) != len(kinds):
            raise ConfigError(f'{name}: expected {len(kinds)} numbers, found {value!r}')
        for item, kind in zip(value, kinds, strict=True):
            self.check(name, item, kind)

    def _check_limits(self, name: str, value: float) -> None:
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        if not low <= value <= high or math.isinf(value):
            unit = f' {self.unit}' if self.unit else ''
            raise ConfigError(f'{name}: expected {low:g} to {high:g}{unit}, found {value!r}')


@dataclass(frozen=True)
class Config:
    """Base of all configuration objects: checks every field when made."""

    def __post_init__(self) -> None:
        for name, (parameter, kind) in parameters_of(type(self)).items():
            value = getattr(self, name)
            if isinstance(value, list):
                value = tuple(value)
            parameter.check(name, value, kind)
            if kind is float:
                value = float(value)
            object.__setattr__(self, name, value)


def parameters_of(config_type: type[Config]) -> dict[str, tuple[Parameter, Any]]:
    """Return the described fields of a configuration class: name to (parameter, type)."""
    found = {}
    for name, hint in get_type_hints(config_type, include_extras=True).items():
        for extra in get_args(hint)[1:]:
            if isinstance(extra, Parameter):
                found[name] = (extra, get_args(hint)[0])
    return found


def flatten(config: Config, prefix: str = '') -> Iterator[tuple[str, Parameter, Any]]:
    """Yield (dotted name, parameter, value) of every field, nested groups included."""
    described = parameters_of(type(config))
    for entry in fields(config):
        value = getattr(config, entry.name)
        if is_dataclass(value):
            assert isinstance(value, Config)
            yield from flatten(value, f'{prefix}{entry.name}.')
        else:
            yield prefix + entry.name, described[entry.name][0], value


def replace_flat(config: ConfigType, values: Mapping[str, Any], prefix: str = '') -> ConfigType:
    """Return a copy of ``config`` with the fields of these dotted names set.

    Raises:
        ConfigError: a name is unknown, or a value has the wrong type or is out of range.
    """
    known = {name for name, _, _ in flatten(config, prefix)}
    for name in values:
        if name not in known:
            raise ConfigError(f'{name}: no such parameter; known are {", ".join(sorted(known))}')
    changes: dict[str, Any] = {}
    for entry in fields(config):
        value, name = getattr(config, entry.name), prefix + entry.name
        if isinstance(value, Config):
            inner = {key: v for key, v in values.items() if key.startswith(f'{name}.')}
            changes[entry.name] = replace_flat(value, inner, f'{name}.')
        else:
            changes[entry.name] = values.get(name, value)
    try:
        return type(config)(**changes)
    except ConfigError as error:
        raise ConfigError(f'{prefix}{error}') from None
