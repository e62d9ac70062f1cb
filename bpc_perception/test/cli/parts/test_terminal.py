"""What a command says, to people, to scripts, and to nobody."""

from dataclasses import replace
import json
import logging
import os

import numpy as np
import pytest

from bpc_perception.cli import compare
from bpc_perception.cli.app import refuse
from bpc_perception.cli.parts.result_table import ResultTable, show_layers
from bpc_perception.cli.parts.terminal import show_held_warnings, Terminal
from bpc_perception.core.inspection.defects import Defect, DefectKind
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.report import comparison
from bpc_perception.runtime.held_warnings import HeldWarnings


def test_people_get_lines(capsys, profile, advice):
    terminal = Terminal()
    ResultTable(terminal).add_profile(profile, advice, PrintVerdict.none(0))
    terminal.warn('look here')
    said = capsys.readouterr()
    head, line = said.out.splitlines()
    assert head.startswith('capture  ink mm')
    assert 'over extrusion: flow x 0.70 or speed x 1.40' in line
    assert said.err == 'bpc: look here\n'


def test_each_defect_is_told_once_as_it_grows(capsys, profile, advice):
    def with_gaps(*ends):
        return replace(PrintVerdict.none(0), defects=tuple(
            Defect(DefectKind.GAP, 1, 0, start, end, end - start, 0.002, 3, (0.0, 0.0, 0.0))
            for start, end in ends))

    table = ResultTable(Terminal())
    for gaps in (((0.01, 0.013),), ((0.01, 0.014),), ((0.01, 0.014), (0.03, 0.035))):
        table.add_profile(profile, advice, with_gaps(*gaps))
    told = [line for line in capsys.readouterr().out.splitlines() if 'gap of' in line]
    assert told == ['  gap of 3.0 mm, at most 2.0 (stroke 1, 10.0 to 13.0 mm)',
                    '  gap of 5.0 mm, at most 2.0 (stroke 1, 30.0 to 35.0 mm)']


def test_what_others_wrote_moves_no_cursor(tmp_path, capsys, profile, advice):
    terminal, odd = Terminal(), tmp_path / os.fsdecode(b'vase-\xff\x1b[2J')
    table = ResultTable(terminal)
    table.add_profile(profile, advice, PrintVerdict.none(0))
    capsys.readouterr()
    table.add_profile(replace(profile, print_id='a\nb\x1b]0;x\x07'), advice,
                      PrintVerdict.none(0))
    terminal.warn('topic\x1b[1m\nOK')
    terminal.say('a:warning:b')
    terminal.files([odd])
    terminal.show(compare.table([{'print': 'a\x1b[31m', 'verdict': '-', **{
        column.key: None for column in comparison.COLUMNS}}]))
    with pytest.raises(SystemExit):
        refuse('bpc: found \x1b[2J\nOK')
    said = capsys.readouterr()
    assert said.out.splitlines()[0] == r'print a b\x1b]0;x\x07'
    assert r'vase-\udcff\x1b[2J' in said.out
    assert '\x1b' not in said.out
    assert 'a:warning:b' in said.out
    assert said.err == 'bpc: topic\\x1b[1m OK\nbpc: found \\x1b[2J OK\n'


def test_scripts_get_an_object_a_line(capsys, profile, advice):
    terminal = Terminal(json_lines=True)
    ResultTable(terminal).add_profile(profile, advice, PrintVerdict.none(0))
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


def test_layers_get_a_line_each(capsys, profile):
    show_layers(Terminal(), profile)
    assert capsys.readouterr().out == ''  # there is but one
    layers = replace(profile, layer=np.array((0, 0, 1, 1)))
    show_layers(Terminal(), layers)
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[1] for line in lines if line[:3].strip('│ ').isdigit()] == ['0', '1']
    assert 'height [mm]' in ''.join(lines)
    show_layers(Terminal(json_lines=True), layers)
    told = [json.loads(line, parse_constant=pytest.fail)
            for line in capsys.readouterr().out.splitlines()]
    assert [(each['event'], each['layer'], each['gap_count']) for each in told] == [
        ('layer', 0, 1), ('layer', 1, 0)]


def test_nobody_gets_nothing(capsys, profile, advice):
    terminal = Terminal(quiet=True)
    ResultTable(terminal).add_profile(profile, advice, PrintVerdict.none(0))
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


def test_warnings_wait_and_are_said_once(capsys):
    held = HeldWarnings()
    for _ in range(2):
        held.emit(logging.LogRecord('bpc', logging.WARNING, '', 0, 'torn', None, None))
    assert capsys.readouterr().err == ''
    show_held_warnings(held)
    assert capsys.readouterr().err == 'bpc: torn\n'
    assert Terminal.newest is not None
