"""Studies on simulated prints of known thickness: the paper's tables and figures, and more."""

from __future__ import annotations

from typing import Any

from bpc_sim.studies.closed_loop.study import CLOSED_LOOP
from bpc_sim.studies.hardware_study import HARDWARE
from bpc_sim.studies.layers_study import LAYERS
from bpc_sim.studies.misfortunes.study import MISFORTUNE_SEARCH
from bpc_sim.studies.paper.sweeps import RESOLUTION, THICKNESS
from bpc_sim.studies.paper.table1 import TABLE1
from bpc_sim.studies.peers.study import PEERS
from bpc_sim.studies.raytraced_study import RAYTRACED
from bpc_sim.studies.stress_study import STRESS_SCENES
from bpc_sim.studies.study_runner import Row, Study
from bpc_sim.studies.verdicts.study import VERDICTS
from bpc_sim.studies.windows.study import WINDOWS

__all__ = ['STUDIES', 'Row', 'Study']

STUDIES: dict[str, Study[Any, Any]] = {
    'table1': TABLE1,
    'resolution': RESOLUTION,
    'thickness': THICKNESS,
    'hardware': HARDWARE,
    'stress': STRESS_SCENES,
    'peers': PEERS,
    'closedloop': CLOSED_LOOP,
    'misfortunes': MISFORTUNE_SEARCH,
    'layers': LAYERS,
    'raytraced': RAYTRACED,
    'verdicts': VERDICTS,
    'windows': WINDOWS,
}
