"""The settings of a capture, as the package ``zivid`` has them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import yaml


@dataclass
class Acquisition:
    """Exposure of one acquisition; nothing here depends on it."""

    brightness: float = 1.8


@dataclass
class Settings2D:
    """Settings of the colour image."""

    acquisitions: list[Acquisition] = field(default_factory=list)

    Acquisition = Acquisition


@dataclass
class Settings:
    """Settings of a capture."""

    acquisitions: list[Acquisition] = field(default_factory=list)
    color: Settings2D | None = None

    Acquisition = Acquisition

    @classmethod
    def load(cls, file_name: str | Path) -> Settings:
        """Load a file as Zivid Studio saves it. Raises RuntimeError for any other file."""
        try:
            content = yaml.safe_load(Path(file_name).read_text())['Settings']
            colour = Settings2D([Acquisition()]) if content.get('Color') else None
            return cls([Acquisition() for _ in content['Acquisitions']], colour)
        except Exception as error:
            raise RuntimeError(f'Failed to load settings: {file_name}') from error
