"""Words for a print beside its design."""

from __future__ import annotations

import math

from bpc_perception.core.design.comparison import DesignFindings
from bpc_perception.core.design.presence import Presence
from bpc_perception.display.units import MM_PER_M


def design_in_words(found: DesignFindings) -> str:
    """Return how far a print is from its design, in a line."""
    if found.registration.refusal:
        return f'beside its design: {found.registration.refusal}'
    parts = [f'{what} off by up to {spread.most_of_95 * MM_PER_M:.2f} mm'
             for what, spread in (('nozzle', found.nozzle), ('bead', found.bead)) if spread.count]
    known = [each for each in found.layers if not math.isnan(each.fidelity)]
    if known:
        points = sum(each.known for each in known)
        fidelity = sum(each.fidelity * each.known for each in known) / points
        parts.append(f'layer fidelity {fidelity:.0%}')
    to_come = sum(each.end - each.start for each in found.missing
                  if each.presence == Presence.YET_TO_COME)
    if to_come > 0:
        parts.append(f'{to_come * MM_PER_M:.0f} mm to come')
    return f'beside its design: {", ".join(parts) or "nothing known yet"}'
