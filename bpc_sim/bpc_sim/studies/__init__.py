"""Studies on simulated prints of known thickness: the paper's tables and figures, and more."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from bpc_sim.studies.cases import case_path, measure_case
from bpc_sim.studies.closedloop import CLOSED_LOOP
from bpc_sim.studies.closedloop_figure import draw
from bpc_sim.studies.peers import PEERS_STUDY
from bpc_sim.studies.scenes import HARDWARE, STRESS_STUDY
from bpc_sim.studies.study import Row, Study
from bpc_sim.studies.sweeps import RESOLUTION, THICKNESS
from bpc_sim.studies.table1 import TABLE1

__all__ = ['STUDIES', 'Row', 'Study', 'case_path', 'measure_case']

STUDIES: dict[str, Study[Any, Any]] = {
    'table1': TABLE1,
    'resolution': RESOLUTION,
    'thickness': THICKNESS,
    'hardware': HARDWARE,
    'stress': STRESS_STUDY,
    'peers': PEERS_STUDY,
    'closedloop': replace(CLOSED_LOOP, draw=draw),
}
