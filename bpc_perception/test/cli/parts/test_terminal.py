"""What a command says, to people, to scripts, and to nobody."""

import io
import json
import logging

import numpy as np
from perception_builders import profile_of
import pytest
from rich.console import Console

from bpc_perception.cli.parts import live_view
from bpc_perception.cli.parts.table import ResultTable
from bpc_perception.cli.parts.terminal import HeldWarnings, tell_warnings, Terminal
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.profile import Status

MM = 1e-3


@pytest.fixture
def profile():
    return profile_of([2 * MM, 0.0, np.nan, 3 * MM],
                      [Status.MEASURED, Status.GAP, Status.NO_DATA, Status.MEASURED])


@pytest.fixture
def advice():
    return RateAdvice(0, 'print', True, Reason.OVER_EXTRUSION, 2 * MM, 3 * MM, (0.0, 3 * MM), 2,
                      0.7, 1.4, 0.5, 1.0, 5 * 10**9)


def test_people_get_lines(capsys, profile, advice):
    terminal = Terminal()
    ResultTable(terminal).add_profile(profile, advice)
    terminal.warn('look here')
    said = capsys.readouterr()
    head, line = said.out.splitlines()
    assert head.startswith('capture  path mm')
    assert 'over extrusion: flow x 0.70 or speed x 1.40' in line
    assert said.err == 'bpc: look here\n'


def test_scripts_get_an_object_a_line(capsys, profile, advice):
    terminal = Terminal(json_lines=True)
    ResultTable(terminal).add_profile(profile, advice)
    terminal.say('for people')
    terminal.warn('look here')
    with terminal.progress('work', 3) as advance, terminal.view():
        advance()
        terminal.draw(lambda: 'nobody looks')
    said = capsys.readouterr()
    capture, warning = (json.loads(line, parse_constant=pytest.fail)
                        for line in said.out.splitlines())
    assert (capture['event'], capture['capture'], capture['samples']) == ('capture', 3, 4)
    assert capture['thickness_mean_mm'] == pytest.approx(2.5)
    assert capture['counts']['GAP'] == 1
    assert capture['advice']['flow_rate_scale'] == 0.7
    assert warning == {'event': 'warning', 'text': 'look here'}
    assert said.err == ''


def test_nobody_gets_nothing(capsys, profile, advice):
    terminal = Terminal(quiet=True)
    ResultTable(terminal).add_profile(profile, advice)
    terminal.warn('look here')
    with terminal.progress('work', 3) as advance:
        advance()
    said = capsys.readouterr()
    assert (said.out, said.err) == ('', '')


def test_quiet_scripts_are_refused():
    with pytest.raises(ValueError, match='expected --quiet or --json, found both'):
        Terminal(True, True)


def test_no_bar_no_colour_without_a_terminal(capsys):
    terminal = Terminal()
    with terminal.progress('work', 2) as advance, terminal.view():
        advance()
        terminal.draw(lambda: 'a view')
        terminal.say('[red]as it is[/red]')
    said = capsys.readouterr()
    assert (said.out, said.err) == ('[red]as it is[/red]\n', '')


class Screen(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def screen(monkeypatch):
    """A terminal to write to; what the tests are started with must not count."""
    for name in ('NO_COLOR', 'FORCE_COLOR', 'COLORTERM'):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv('TERM', 'xterm-256color')
    return Screen()


def test_a_bar_tells_rate_and_time_left(screen, monkeypatch):
    monkeypatch.setattr('sys.stdout', screen)
    terminal = Terminal()
    with terminal.progress('work', 4) as advance:
        for _ in range(4):
            advance()
            terminal.say('a line')
    assert 'work' in screen.getvalue()
    assert '/4' in screen.getvalue()
    assert screen.getvalue().count('a line') == 4


def test_a_view_is_drawn_below_the_lines(screen, monkeypatch):
    monkeypatch.setattr('sys.stdout', screen)
    terminal = Terminal()
    with terminal.view():
        terminal.draw(lambda: 'the view')
        terminal.draw(lambda: 'too soon')
        terminal.say('a line')
    text = screen.getvalue()
    assert 'the view' in text
    assert 'too soon' not in text


def test_colours_end_where_they_are_not_wanted(screen, monkeypatch, profile, advice):
    def drawn():
        Console(file=screen).print(live_view.profile_line(profile, advice, 40))
        text = screen.getvalue()
        screen.seek(0)
        screen.truncate()
        return text

    assert '\x1b[38' in drawn()
    monkeypatch.setenv('NO_COLOR', '1')
    assert '\x1b[3' not in drawn()


def test_view_has_a_letter_a_sample(profile, advice):
    # On target is half height, half as much again is three quarters; a gap and glare have signs.
    assert live_view.profile_line(profile, advice, 40).plain == '▄_·▆'
    assert live_view.profile_line(profile_of([]), advice, 40).plain == ''
    lines = [line.plain for line in live_view.view(profile, advice, 40, 2.0).renderables]
    assert lines[1] == ('0 to 3.0 mm: 2.500 ± 0.500 mm, target 2.000 mm, 75% known;  '
                        '_ gap, · no data')
    assert lines[2].endswith('capture 3, 2 s ago')


def test_warnings_wait_and_are_said_once(capsys):
    held = HeldWarnings()
    for _ in range(2):
        held.emit(logging.LogRecord('bpc', logging.WARNING, '', 0, 'torn', None, None))
    assert capsys.readouterr().err == ''
    tell_warnings(held)
    assert capsys.readouterr().err == 'bpc: torn\n'
    assert Terminal.newest is not None
