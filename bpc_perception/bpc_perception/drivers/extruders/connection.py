"""A connection to an extruder that is opened again after the device was gone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
import time

from bpc_perception.core.config import ExtruderConfig
from bpc_perception.core.extruder.tic import ExtruderError, TicState
from bpc_perception.core.watch.back_off import BackOff
from bpc_perception.drivers.extruders.devices import Extruder, load_packages, open_extruder, Refuse
from bpc_perception.drivers.extruders.ports import lasting_name, only_device


class ExtruderConnection:
    """Reads an extruder. While it is gone, it is looked for after pauses that grow.

    Args:
        config: names the device and the time without a state after which it is gone.
        refuse: gets what cannot be used, and the reason why the device is gone.
        on_open: is called when the device has been opened, before its first state.

    Raises ValueError when the package for the device is not installed.
    """

    def __init__(self, config: ExtruderConfig, refuse: Refuse,
                 on_open: Callable[[], None]) -> None:
        self._config = config
        self._port = config.port  # once the device was open, the name that it keeps
        self._refuse = refuse
        self._on_open = on_open
        self._back_off = BackOff()
        self._extruder: Extruder | None = None
        self._heard = 0.0  # when the last state came, or the device was opened [s], steady
        load_packages(config)
        self._open()

    def poll(self) -> list[TicState]:
        """Return the states since the last call; none while the device is gone."""
        if self._extruder is None:
            if not self._back_off.waiting(time.monotonic()):
                self._open()
            return []
        try:
            states = self._extruder.read()
            if not states and time.monotonic() - self._heard > self._config.timeout:
                raise ExtruderError('extruder: expected a state each '
                                    f'{self._config.timeout:g} s, found none'
                                    '; look at its power and cable')
        except ExtruderError as error:
            self._refuse(error)
            self.close()
            self._back_off.failed(time.monotonic())
            return []
        if states:
            self._back_off.succeeded()
            self._heard = time.monotonic()
        return states

    def close(self) -> None:
        """Close the device, if it is open."""
        if self._extruder is not None:
            self._extruder.close()
            self._extruder = None

    def _open(self) -> None:
        """Open the device, or note when to try again."""
        self._heard = time.monotonic()
        try:
            port = self._port or only_device()
            self._extruder = open_extruder(replace(self._config, port=port), self._refuse)
        except ExtruderError as error:
            self._refuse(error)
            self._back_off.failed(self._heard)
            return
        self._port = lasting_name(port)
        self._on_open()
