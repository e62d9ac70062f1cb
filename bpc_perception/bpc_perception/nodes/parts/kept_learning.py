"""Keep in a file what prints taught."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.learning.layer_schedule import LayerSchedule
from bpc_perception.files.learned_file import load_learned, save_learned
from bpc_perception.files.yaml_file import FileError


class KeptLearning:
    """What prints taught, and in the file if there is one.

    Attributes:
        told: as it was kept last; None = nothing, or of another ink or nozzle.
    """

    def __init__(self, config: ThicknessConfig, warn: Callable[[str], object]) -> None:
        """Read what is kept; ``warn`` hears of what is not used, and of what cannot be kept."""
        self._config, self._warn = config.learning, warn
        self._writes = bool(config.learning.file and config.learning.enabled)
        self.told: LayerSchedule | None = None
        if self._writes and not (config.learning.ink and config.learning.nozzle):
            self._writes = False
            warn('learning.file: expected learning.ink and learning.nozzle with it, found one '
                 'empty; name both, what is learned holds for them alone')
        try:
            self.told = load_learned(config.learning, config.advice) if self._writes else None
        except FileError as error:
            self._writes = False  # what is not ours is not written over
            warn(f'learning.file: {error}')

    def keep(self, told: LayerSchedule | None) -> None:
        """Keep what is told for the next print, if it is another."""
        if (not self._writes or told is None or not told.valid or told.print_id
                or told is self.told):
            return
        self.told = told
        try:
            save_learned(Path(self._config.file), told, self._config)
        except OSError as error:
            self._warn(f'learning.file: expected to write {self._config.file}, found: {error}; '
                       'make room there, or let it be written to')
