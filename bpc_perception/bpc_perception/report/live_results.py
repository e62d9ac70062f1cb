"""The results of prints while they are measured live, each in the folder of its print."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.design.comparison import DesignFollower, path_of, WantedDesign
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.result import Result
from bpc_perception.recording.print_folder import print_folder
from bpc_perception.report.outputs import write_outputs
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import Provenance
from bpc_perception.report.result_folder import read_summary


def seen(stamp_ns: int, image: NDArray[np.uint8], camera: PinholeCamera) -> Capture:
    """Return a capture of an image (H, W, 3) alone: its cloud has no points, and no memory."""
    cloud = np.broadcast_to(np.float32(np.nan), image.shape)
    return Capture(stamp_ns, '', image, cloud, camera)


class LiveResults:
    """Takes profile and advice of each capture, and writes what is known of the newest print.

    Attributes:
        print_id: of the newest print; empty = none was measured.
        changed: whether there is something that is not written yet.
    """

    def __init__(self, prints: Path, design: WantedDesign | None = None) -> None:
        self._prints = prints
        self._design = DesignFollower(design) if design else None
        self._log = PrintLog()
        self.print_id = ''
        self.changed = False

    @property
    def folder(self) -> Path:
        """The folder of the newest print."""
        return print_folder(self._prints, self.print_id)

    def begins_with(self, print_id: str) -> bool:
        """Return whether this is another print than the newest one."""
        return print_id != self.print_id

    def add(self, profile: ThicknessProfile, result: Result) -> None:
        """Take a result with its profile; begin anew if it is of another print.

        What was written of that print before, as by a process that was killed, is gone on with.
        """
        if self.begins_with(profile.print_id):
            self._log, self.print_id = PrintLog(), profile.print_id
            self._log.go_on(_written(self.folder, self.print_id))
        self._log.add(result)
        self.changed = True

    def end(self) -> None:
        """Take note that nothing more of the newest print comes, for now."""
        self._compare()
        self._log.end()
        self.changed = True

    def write(self, provenance: Provenance) -> list[Path]:
        """Write profile.csv, summary.json and report.html; return their paths.

        Raises OSError. What was written before is still there then.
        """
        self._compare()
        files = write_outputs(self.folder, self._log, provenance)
        self.changed = False
        return files


    def _compare(self) -> None:
        """Compare the newest result with its design, which is worth it only when it is written."""
        result = self._log.reported
        if (self._design is None or result is None or result.design is not None
                or result.profile is None or result.verdict is None):
            return
        path = path_of(result.profile, result.verdict.ended)
        self._log.reported = replace(result, design=self._design.compare(result.profile, path))


def _written(folder: Path, print_id: str) -> list[dict[str, Any]]:
    """Return what a summary in a folder says of the captures of a print; nothing if it cannot."""
    try:
        summary = read_summary(folder)
        return list(summary['captures']) if summary['print_id'] == print_id else []
    except (OSError, ValueError, LookupError, TypeError):
        return []
