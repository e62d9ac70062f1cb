"""One browser's view of the board."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
import math

from nicegui import ui
import numpy as np

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.display.legend import COLOURS
from bpc_perception.display.wording import label, MEANINGS
from bpc_perception.page import chart, elements
from bpc_perception.page.board import Board, Goal, Level
from bpc_perception.page.curve import stretches, thinned
from bpc_perception.page.words import advised, age_in_words, in_mm, in_percent, MM

NEWEST = 0.05  # of the path in the close view [m]
GAPS = 4  # told one by one, the newest
EVENTS = 6
ACTIONS = {'capture': 'Capture', 'start': 'Start', 'stop': 'Stop', 'save': 'Save'}
Act = Callable[[str], Awaitable[tuple[bool, str]]]
TONES = {Level.OK: 'good', Level.WARN: 'warn', Level.ERROR: 'bad', Level.STALE: 'old',
         Level.UNHEARD: 'old'}


class View:
    """The elements of one browser's page; to be made within its client.

    Args:
        board: what is shown.
        act: does what a button says; None = no buttons.
    """

    def __init__(self, board: Board, act: Act | None) -> None:
        self._board = board
        self._act = act
        self.dark = False
        self._drawn: object = ()  # what the chart and all of a profile was made of
        self._shown_overlay: object = ()
        self._shown_events: object = None
        self._shown_nodes: object = None
        ui.colors(primary=COLOURS[Status.MEASURED])
        with ui.element('main').classes('board'):
            self._make_top()
            self._make_advice()
            self._make_numbers()
            self._make_chart()
            self._make_overlay()
            with ui.element('div').classes('area-side'):
                with elements.card('nodes', 'Nodes'):
                    self._nodes = ui.element('div').classes('entries')
                with elements.card('events', 'Gaps and alarms'):
                    self._events = ui.element('div').classes('entries')
        self.refresh()

    def _make_top(self) -> None:
        with ui.element('header').classes('area-top'):
            self._print = ui.label().classes('print')
            self._capture = ui.label().classes('quiet capture')
            if self._act is not None:
                with ui.element('div').classes('actions'):
                    for name, words in ACTIONS.items():
                        ui.button(words, on_click=lambda name=name: self._press(name)).props(
                            'unelevated no-caps' if name == 'capture' else 'outline no-caps'
                        ).classes(f'action-{name}')

    def _make_advice(self) -> None:
        with ui.element('section').classes('card area-advice') as self._advice:
            with ui.element('div').classes('title'):
                ui.label('Advice')
                self._age = ui.label().classes('age')
            self._headline = ui.label().classes('headline').props('role=status')
            self._otherwise = ui.label().classes('otherwise')
            self._reason = ui.label().classes('reason')

    def _make_numbers(self) -> None:
        with ui.element('section').classes('card area-numbers'):
            self._thickness = elements.number('newest thickness', 'mm', 'largest')
            self._target = elements.number('target', 'mm')
            self._deviation = elements.number('off target', '%')
            self._mean = elements.number('mean ± deviation', 'mm')
            self._known = elements.number('known', '%')
            self._gaps = elements.number('in gaps', 'mm')

    def _make_chart(self) -> None:
        with elements.card('chart', 'Thickness along the path') as title:
            with title:
                self._close = ui.switch(f'newest {NEWEST * MM:.0f} mm',
                                        on_change=self.refresh).props('dense')
            self._chart = ui.echart({'series': []}).classes('chart')
            self._legend = ui.element('div').classes('legend')

    def _make_overlay(self) -> None:
        with elements.card('overlay', 'Camera'):
            with ui.link(target='/overlay.jpg', new_tab=True) as self._overlay_link:
                self._overlay = ui.interactive_image().classes('overlay')
            self._overlay_note = ui.label('The picture comes with the next measured capture.'
                                          ).classes('quiet')

    async def _press(self, name: str) -> None:
        """Do what a button says, and tell what came of it."""
        assert self._act is not None
        if name == 'stop' and not await self._sure():
            return
        done, words = await self._act(name)
        ui.notify(f'{ACTIONS[name]}: {words}', type='positive' if done else 'negative',
                  position='top', multi_line=True, classes='outcome')

    async def _sure(self) -> bool:
        """Whether to stop: a thumb on a phone slips, and a path cannot be resumed."""
        with ui.dialog() as dialog, ui.card():
            ui.label('Stop recording the path? What is printed from now on is not measured.')
            with ui.element('div').classes('actions'):
                ui.button('Go on', on_click=lambda: dialog.submit(False)).props('outline no-caps')
                ui.button('Stop', on_click=lambda: dialog.submit(True)).props(
                    'unelevated no-caps color=negative').classes('sure')
        return bool(await dialog)

    def refresh(self) -> None:
        """Show what is new on the board, and how old the rest has become."""
        board = self._board
        self._show_advice()
        now = (board.profile, board.advice, board.goal, self._close.value, self.dark)
        if now != self._drawn:
            self._drawn = now
            if board.profile is None:
                self._show_no_profile()
            else:
                self._show_profile(board.profile)
        if board.overlay is not self._shown_overlay:
            self._shown_overlay = board.overlay
            if board.overlay is not None:
                address = f'/overlay.jpg?capture={board.overlay.stamp_ns}'
                self._overlay.set_source(address)
                self._overlay_link.props['href'] = address
            self._overlay_link.set_visibility(board.overlay is not None)
            self._overlay_note.set_visibility(board.overlay is None)
        if (nodes := board.health()) != self._shown_nodes:
            self._shown_nodes = nodes
            self._show_nodes(nodes)
        if (told := (board.events, board.profile)) != self._shown_events:
            self._shown_events = told
            self._show_events()

    def _show_advice(self) -> None:
        advice, now_ns = self._board.advice, self._board.now_ns()
        shown = advised(advice, now_ns)
        self._headline.set_text(shown.headline)
        self._otherwise.set_text(shown.otherwise)
        self._reason.set_text(shown.reason)
        age = '' if advice is None else f'{age_in_words((now_ns - advice.stamp_ns) * 1e-9)} old'
        self._age.set_text(age)
        elements.set_tone(self._advice, shown.tone)
        if advice is None:
            return
        target = advice.target_thickness
        self._thickness.set_text(in_mm(advice.measured_thickness))
        self._target.set_text(in_mm(target if target > 0 else math.nan))
        off = advice.measured_thickness / target - 1 if target > 0 else math.nan
        self._deviation.set_text(in_percent(off, '+.1%'))

    def _show_no_profile(self) -> None:
        """As before a print: a recording that starts again has none yet."""
        self._print.set_text('')
        self._capture.set_text('')
        for number in (self._mean, self._known, self._gaps):
            number.set_text('–')
        self._legend.clear()
        self._chart.options.clear()
        self._chart.options.update({'series': []})
        self._chart.update()

    def _show_profile(self, profile: ThicknessProfile) -> None:
        summary = profile.summary
        self._print.set_text(profile.print_id)
        length = profile.arc_length[-1] if len(profile) else 0.0
        self._capture.set_text(f'capture {profile.capture}, {length * MM:.0f} mm of path')
        self._mean.set_text(f'{in_mm(summary.thickness_mean)} ± {in_mm(summary.thickness_std)}')
        self._known.set_text(in_percent(summary.coverage, '.0%'))
        self._gaps.set_text(in_mm(summary.gap_length, 1))
        start = max(0.0, length - NEWEST) if self._close.value else 0.0
        marked, goal = stretches(profile, start), self._goal()
        self._chart.options.clear()
        self._chart.options.update(chart.options(
            thinned(profile, start), marked, goal, (start, max(length, start + 1e-3)),
            self.dark))
        self._chart.update()
        self._show_legend({stretch.status for stretch in marked}, profile, goal)

    def _goal(self) -> Goal | None:
        """What is wanted; of a thickness node that does not tell, what its advice says."""
        if self._board.goal is not None or self._board.advice is None:
            return self._board.goal
        target = self._board.advice.target_thickness
        return Goal(WidthTargets.constant(target), math.nan) if target > 0 else None

    def _show_legend(self, statuses: set[Status], profile: ThicknessProfile,
                     goal: Goal | None) -> None:
        self._legend.clear()
        with self._legend:
            elements.key(COLOURS[Status.MEASURED], 'thickness ± sigma')
            if goal is not None:
                elements.key(chart.TARGET, 'target' if math.isnan(goal.dead_band)
                     else f'target ± {goal.dead_band:.0%}')
            for status in sorted(statuses):
                share = np.mean(profile.status == status)
                key = elements.key(COLOURS[status], f'{label(status)} {share:.0%}')
                key.tooltip(MEANINGS[status])

    def _show_nodes(self, nodes: dict[str, tuple[Level, str]]) -> None:
        self._nodes.clear()
        with self._nodes:
            for name, (level, words) in nodes.items():
                with ui.element('div').classes(f'entry {TONES[level]}'):
                    ui.element('span').classes('dot')
                    ui.label(name).classes('name')
                    ui.label(words).classes('words')

    def _show_events(self) -> None:
        self._events.clear()
        profile = self._board.profile
        gaps = profile.gaps[::-1] if profile is not None else np.empty((0, 2))
        with self._events:
            for event in self._board.events[:EVENTS]:
                with ui.element('div').classes(f'entry {"bad" if event.alarm else "warn"}'):
                    ui.element('span').classes('dot')
                    ui.label(event.at).classes('name')
                    times = f' ({event.times} times)' if event.times > 1 else ''
                    ui.label(f'{event.source}: {event.words}{times}').classes('words')
            for start, end in gaps[:GAPS]:
                with ui.element('div').classes('entry gap'):
                    ui.element('span').classes('dot')
                    ui.label(f'{start * MM:.1f} mm').classes('name')
                    ui.label(f'gap of {(end - start) * MM:.1f} mm').classes('words')
            if len(gaps) > GAPS:
                ui.label(f'and {len(gaps) - GAPS} gaps before').classes('quiet')
            if not len(gaps) and not self._board.events:
                ui.label('none').classes('quiet')
