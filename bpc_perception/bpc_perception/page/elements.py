"""The parts that the page is made of; page.css says how they look."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from nicegui import ui

TONES = ('good', 'act', 'bad', 'old')


@contextmanager
def card(area: str, words: str) -> Iterator[ui.element]:
    """A card with its title, to which more can be added."""
    with ui.element('section').classes(f'card area-{area}'):
        with ui.element('div').classes('title') as title:
            ui.label(words)
        yield title


def number(words: str, unit: str, size: str = '') -> ui.label:
    """A number with what it is and its unit."""
    with ui.element('div').classes(f'number {size}'):
        ui.label(words).classes('quiet')
        with ui.element('div'):
            value = ui.label('–').classes('value')
            ui.label(unit).classes('unit')
    return value


def key(colour: str, words: str) -> ui.element:
    """An entry of the legend."""
    with ui.element('span').classes('key') as key:
        ui.element('span').classes('chip').style(f'background: {colour}')
        ui.label(words)
    return key


def set_tone(element: ui.element, tone: str) -> None:
    """Give an element the one of TONES that fits."""
    element.classes(add=tone, remove=' '.join(other for other in TONES if other != tone))
