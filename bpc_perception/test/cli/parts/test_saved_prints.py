"""What a command says at its end about the prints it has kept."""

from bpc_perception.cli.parts.saved_prints import say_what_is_saved
from bpc_perception.cli.parts.terminal import Terminal


def test_a_print_without_a_result_is_not_left_out(tmp_path, capsys):
    for name, files in (('measured', ('profile.csv', 'summary.json')), ('short', ('recording',))):
        (tmp_path / name).mkdir()
        for file in (*files, '.part'):
            (tmp_path / name / file).touch()
    say_what_is_saved([tmp_path / 'measured', tmp_path / 'short'], Terminal(False, False))
    said = capsys.readouterr().out.splitlines()
    assert said == [str(tmp_path / 'measured' / 'profile.csv'),
                    str(tmp_path / 'measured' / 'summary.json'),
                    str(tmp_path / 'short' / 'recording'),
                    f'{tmp_path / "short"}: no capture of this print was measured.']


def test_that_no_print_began_is_said(capsys):
    say_what_is_saved([], Terminal(False, False))
    assert capsys.readouterr().out == 'Nothing is saved: no print began.\n'
