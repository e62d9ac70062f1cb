"""The elements that the panels are made of; page.css says how they look."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from nicegui import ui

TONES = ('good', 'act', 'bad', 'old')


@contextmanager
def card(area: str, words: str) -> Iterator[ui.element]:
    """Make a card with a title; the block gets the title, to which more can be added."""
    with ui.element('section').classes(f'card area-{area}'):
        with ui.element('div').classes('title') as title:
            ui.label(words)
        yield title


def number(words: str, unit: str, size: str = '') -> ui.label:
    """Make a number with its name and unit; return the element that holds its value."""
    with ui.element('div').classes(f'number {size}'):
        ui.label(words).classes('quiet')
        with ui.element('div'):
            value = ui.label('–').classes('value')
            ui.label(unit).classes('unit')
    return value


def key(colour: str, words: str) -> ui.element:
    """Make an entry of the legend."""
    with ui.element('span').classes('key') as key:
        ui.element('span').classes('chip').style(f'background: {colour}')
        ui.label(words)
    return key


def entry(tone: str, name: str, words: str) -> None:
    """Make an entry of a list: a dot in a tone, a name, and words."""
    with ui.element('div').classes(f'entry {tone}'):
        ui.element('span').classes('dot')
        ui.label(name).classes('name')
        ui.label(words).classes('words')


def set_tone(element: ui.element, tone: str) -> None:
    """Give an element one of TONES and take the others away."""
    element.classes(add=tone, remove=' '.join(other for other in TONES if other != tone))
