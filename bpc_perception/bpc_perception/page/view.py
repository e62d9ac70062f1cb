"""One browser's view of the board."""

from __future__ import annotations

import math

from nicegui import ui

from bpc_perception.core.profile import Status
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.design_words import design_in_words
from bpc_perception.display.legend import STATUS_COLOURS
from bpc_perception.page.board import Board, TargetBand
from bpc_perception.page.panels.advice import AdvicePanel, NumbersPanel
from bpc_perception.page.panels.chart import ChartPanel
from bpc_perception.page.panels.header import Act, Header
from bpc_perception.page.panels.lists import EventsPanel, NodesPanel
from bpc_perception.page.panels.overlay import OverlayPanel


class View:
    """The elements of one browser's page; made within its client.

    Args:
        board: what is shown.
        act: does what a button says; None = no buttons.
    """

    def __init__(self, board: Board, act: Act | None) -> None:
        self._board = board
        self.dark = False
        self._shown: dict[str, object] = {}  # by part of the page, from what it was made
        ui.colors(primary=STATUS_COLOURS[Status.MEASURED])
        with ui.element('main').classes('board'):
            self._header = Header(act)
            self._advice = AdvicePanel()
            self._numbers = NumbersPanel()
            self._chart = ChartPanel(self.refresh)
            self._overlay = OverlayPanel()
            with ui.element('div').classes('area-side'):
                self._nodes = NodesPanel()
                self._events = EventsPanel()
        self.refresh()

    def refresh(self) -> None:
        """Show what is new on the board, and how old the rest has become."""
        board = self._board
        self._advice.show(board.advice, board.now_ns())
        self._numbers.show_advice(board.advice)
        if self._is_new('profile', (board.profile, board.advice, board.target,
                                    self._chart.newest_only, self.dark)):
            self._show_profile()
        if self._is_new('overlay', board.overlay):
            self._overlay.show(board.overlay)
        if self._is_new('verdict', board.verdict):
            self._header.show_verdict(board.verdict)
        design = design_in_words(board.design) if board.design is not None else ''
        if self._is_new('design', design):
            self._header.show_design(design)
        nodes = board.health()
        if self._is_new('nodes', nodes):
            self._nodes.show(nodes)
        if self._is_new('events', (board.events, board.profile, board.verdict)):
            self._events.show(board.events, board.profile, board.verdict)

    def _is_new(self, part: str, state: object) -> bool:
        """Return whether a part of the page was not made from this state, and note the state."""
        if part in self._shown and self._shown[part] == state:
            return False
        self._shown[part] = state
        return True

    def _show_profile(self) -> None:
        """Show the profile; there is none before a print, and when a recording starts again."""
        profile = self._board.profile
        self._header.show(profile)
        self._numbers.show_profile(profile)
        if profile is None:
            self._chart.clear()
        else:
            self._chart.show(profile, self._target(), self.dark)

    def _target(self) -> TargetBand | None:
        """Return the target; if the thickness node does not say it, that of the advice."""
        target, advice = self._board.target, self._board.advice
        if target is not None or advice is None:
            return target
        thickness = advice.target_thickness
        return TargetBand(WidthTargets.constant(thickness), math.nan) if thickness > 0 else None
