"""The lists at the side: how the nodes are, and what happened."""

from __future__ import annotations

from nicegui import ui

from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.display.units import MM_PER_M
from bpc_perception.page import elements
from bpc_perception.page.board import Event, Level

MOST_DEFECTS, MOST_EVENTS = 4, 6  # that are listed, the newest
LEVEL_TONES = {Level.OK: 'good', Level.WARN: 'warn', Level.ERROR: 'bad', Level.STALE: 'old',
               Level.UNHEARD: 'old'}


class NodesPanel:
    """Each node with its level and words."""

    def __init__(self) -> None:
        with elements.card('nodes', 'Nodes'):
            self._entries = ui.element('div').classes('entries')

    def show(self, nodes: dict[str, tuple[Level, str]]) -> None:
        """Show level and words of nodes, by name."""
        self._entries.clear()
        with self._entries:
            for name, (level, words) in nodes.items():
                elements.entry(LEVEL_TONES[level], name, words)


class EventsPanel:
    """The newest events, gaps and ooze."""

    def __init__(self) -> None:
        with elements.card('events', 'Gaps, ooze and alarms'):
            self._entries = ui.element('div').classes('entries')

    def show(self, events: tuple[Event, ...], profile: ThicknessProfile | None) -> None:
        """Show events, and gaps and ooze of a profile if there is one."""
        found = [] if profile is None else [
            (start, end, word) for word, extents in (('gap', profile.gaps), ('ooze', profile.ooze))
            for start, end in extents.tolist()]
        found.sort(reverse=True)
        self._entries.clear()
        with self._entries:
            for event in events[:MOST_EVENTS]:
                times = f' ({event.times} times)' if event.times > 1 else ''
                elements.entry('bad' if event.alarm else 'warn', event.at,
                               f'{event.source}: {event.words}{times}')
            for start, end, word in found[:MOST_DEFECTS]:
                elements.entry('gap', f'{start * MM_PER_M:.1f} mm',
                               f'{word} of {(end - start) * MM_PER_M:.1f} mm')
            if len(found) > MOST_DEFECTS:
                ui.label(f'and {len(found) - MOST_DEFECTS} before').classes('quiet')
            if not found and not events:
                ui.label('none').classes('quiet')
