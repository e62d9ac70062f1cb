"""The newest profile as a line of letters."""

from perception_builders import profile_of
from rich.console import Console

from bpc_perception.cli.parts import live_view
from bpc_perception.core.inspection.verdict import PrintVerdict


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
    lines = [line.plain for line in live_view.view(
        profile, advice, PrintVerdict.none(0), 40, 2.0).renderables]
    assert lines[1] == ('0 to 3.0 mm: 2.500 ± 0.500 mm, target 2.000 mm, 75% known;  '
                        '_ gap, · no data')
    assert lines[3].endswith('capture 3, 2 s ago')
