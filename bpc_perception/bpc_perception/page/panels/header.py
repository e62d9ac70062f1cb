"""The top of the page: which print, whether it is good, which capture, and the buttons."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.verdict_words import TONES, verdict_in_words
from bpc_perception.page import elements

BUTTONS = {'capture': 'Capture', 'start': 'Start', 'stop': 'Stop', 'save': 'Save'}
QUESTIONS = {
    'start': 'Start a new print? The one that is shown is left for good.',
    'stop': 'Stop recording the path? What is printed from now on is not measured.'}
Act = Callable[[str], Awaitable[tuple[bool, str]]]


class Header:
    """Print, verdict, capture and buttons.

    Args:
        act: does what a button says and returns whether it was done, and in words; None = no
            buttons.
    """

    def __init__(self, act: Act | None) -> None:
        self._act = act
        with ui.element('header').classes('area-top'):
            self._print = ui.label().classes('print')
            self._verdict = ui.label().classes('verdict').props('role=status')
            self._capture = ui.label().classes('quiet capture')
            self._design = ui.label().classes('quiet design')
            if act is not None:
                with ui.element('div').classes('actions'):
                    for name in BUTTONS:
                        self._make_button(name)

    def _make_button(self, name: str) -> None:
        look = 'unelevated no-caps' if name == 'capture' else 'outline no-caps'
        ui.button(BUTTONS[name], on_click=lambda: self._press(name)).props(look).classes(
            f'action-{name}')

    async def _press(self, name: str) -> None:
        """Do what a button says, and show what came of it."""
        assert self._act is not None
        asked = name == 'stop' or (name == 'start' and self._print.text)
        if asked and not await _confirm(name):
            return
        done, words = await self._act(name)
        ui.notify(f'{BUTTONS[name]}: {words}', type='positive' if done else 'negative',
                  position='top', multi_line=True, classes='outcome')

    def show_verdict(self, verdict: PrintVerdict | None) -> None:
        """Show whether the print is good; None = nothing is known yet."""
        self._verdict.set_visibility(verdict is not None)
        if verdict is not None:
            self._verdict.set_text(verdict_in_words(verdict))
            elements.set_tone(self._verdict, TONES[verdict.verdict])

    def show_design(self, words: str) -> None:
        """Show how far the print is from its design; empty = not known, or there is none."""
        self._design.set_visibility(bool(words))
        self._design.set_text(words)

    def show(self, profile: ThicknessProfile | None) -> None:
        """Show a profile; None = there is none yet."""
        if profile is None:
            self._print.set_text('')
            self._capture.set_text('')
            return
        length = profile.arc_length[-1] if len(profile) else 0.0
        self._print.set_text(profile.print_id)
        self._capture.set_text(f'capture {profile.capture}, {length * MM_PER_M:.0f} mm of path')


async def _confirm(name: str) -> bool:
    """Ask whether a button is meant: a thumb on a phone slips, and a print is left for good."""
    with ui.dialog() as dialog, ui.card():
        ui.label(QUESTIONS[name])
        with ui.element('div').classes('actions'):
            ui.button('Go on', on_click=lambda: dialog.submit(False)).props('outline no-caps')
            ui.button(BUTTONS[name], on_click=lambda: dialog.submit(True)).props(
                'unelevated no-caps color=negative').classes('sure')
    return bool(await dialog)
