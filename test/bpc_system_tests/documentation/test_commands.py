"""Every command that a page names exists, with its options and arguments."""

from __future__ import annotations

import ast
from collections.abc import Iterator
import importlib.util
from itertools import pairwise
from pathlib import Path
import re
import shlex
from typing import Any

import pytest
import typer

from bpc_perception.cli.app import command_line
from bpc_system_tests.documentation import command_tables
from bpc_system_tests.documentation.pages import (
    all_code,
    Code,
    IDS,
    PAGES,
    read,
    ROOT,
    section,
    table_rows,
    without_blocks,
)
from bpc_system_tests.robustness.test_faults import TESTS

README = ROOT / 'README.md'
INSTALLED = ROOT / 'docs' / 'tutorials' / 'installed_jazzy.md'
LIVE_LAUNCH = ROOT / 'bpc_perception' / 'launch' / 'live.launch.py'
ENV = 'env'  # answered by the set-up, before there is a command line
COMMAND = re.compile(r'\./bpc((?: [^`|;&)"#]+)?)')
# Of Click, which newer versions of Typer bring along under a name of their own.
UsageError: Any = typer.BadParameter.__base__


def bpc_commands() -> Iterator[tuple[Code, list[str]]]:
    """Yield the words behind each ``./bpc`` in the code of all pages."""
    for code in all_code():
        for found in COMMAND.findall(code.text):
            yield code, shlex.split(found)


def parse(words: list[str], complete: bool = True) -> None:
    """Parse a command line as the program does, but run nothing.

    Args:
        words: behind ``./bpc``.
        complete: whether required arguments and options have to be there, and values to fit.

    Raises:
        UsageError: a command, an option or an argument is not as the command line wants it.
    """
    command = typer.main.get_command(command_line())
    while is_group(command) and words and words != ['--help']:
        _, command, words = command.resolve_command(empty_context(command), words)
    if words == ['--help']:
        return
    if is_group(command):
        if complete:
            raise UsageError('expected a command, found none')
    elif complete:
        command.make_context(command.name, words)
    else:
        _, surplus, _ = command.make_parser(empty_context(command)).parse_args(words)
        if surplus:
            raise UsageError(f'surplus arguments: {surplus}')


def is_group(command: Any) -> bool:
    """Whether a command only holds others."""
    return hasattr(command, 'commands')


def empty_context(command: Any) -> Any:
    """Return a context without arguments, which does not forgive what comes later."""
    ctx = command.make_context(command.name, [], resilient_parsing=True)
    ctx.resilient_parsing = False
    return ctx


def refuse(code: Code, words: list[str]) -> str:
    """Return why the command line refuses a command of a page; empty = it does not."""
    try:
        if words != [ENV]:
            parse(words, complete=code.in_block)
    except UsageError as error:
        return f'{code.page.relative_to(ROOT)}: {code.text}: {error}'
    return ''


def launch_arguments(file: Path) -> set[str]:
    """Return the names that a launch file declares, as far as they are strings in it."""
    return {node.value for node in ast.walk(ast.parse(file.read_text(encoding='utf-8')))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)}


def test_commands_are_found() -> None:
    assert sum(code.in_block for code, _ in bpc_commands()) >= 25
    assert sum(not code.in_block for code, _ in bpc_commands()) >= 50


@pytest.mark.parametrize('words', [
    'nothing', 'demo --nothing', 'demo extra', 'measure', 'measure bag', 'measure bag --out',
    'sim --scenario', 'calibrate', 'calibrate nothing', 'calibrate nozzle', 'sim --speed fast'])
def test_a_wrong_command_line_is_refused(words: str) -> None:
    with pytest.raises(UsageError):
        parse(words.split())


@pytest.mark.parametrize('words', [
    'nothing', 'demo --nothing', 'demo extra', 'sim --scenario', 'calibrate nothing'])
def test_a_wrong_command_within_a_line_is_refused(words: str) -> None:
    with pytest.raises(UsageError):
        parse(words.split(), complete=False)


def test_commands_are_whole_in_blocks_and_exist_within_lines() -> None:
    refused = [why for code, words in bpc_commands() if (why := refuse(code, words))]
    assert refused == []


def test_every_option_that_a_command_takes_is_in_its_help() -> None:
    for name, command in command_tables.commands().items():
        told = command.get_help(command_tables.context(name, command))
        for parameter in command.params:
            for option in parameter.opts:
                assert not option.startswith('-') or option in told, (name, option)


@pytest.mark.parametrize('page', [README, command_tables.PAGE], ids=lambda page: str(page.name))
def test_every_command_is_in_the_table(page: Path) -> None:
    for command in [*command_tables.commands(), ENV]:
        assert re.search(rf'^\| \[?`(\./bpc )?{command}\b', read(page), re.MULTILINE), command


@pytest.mark.parametrize('page', [README, command_tables.PAGE], ids=lambda page: str(page.name))
def test_options_named_beside_a_command_exist(page: Path) -> None:
    known = {name: {option for parameter in command.params for option in parameter.opts}
             for name, command in command_tables.commands().items()}
    found = set()
    for cells in table_rows(read(page)):
        words = re.findall(r'[a-z-]+', cells[0].replace('./bpc', ''))
        name = next((each for each in (' '.join(words[:2]), *words[:1]) if each in known), '')
        found |= {name} - {''}
        for option in re.findall(r'`(--[a-z\d-]+)', ' '.join(cells)) if name else ():
            assert option in known[name], (name, option)
    assert found == set(known)


@pytest.mark.parametrize('name', ['check', 'live', 'record', 'calibrate handeye'])
def test_examples_for_a_rig_name_its_parameters(name: str) -> None:
    rig = [' '.join(words) for code, words in bpc_commands() if code.in_block
           and re.search(r'--(handeye|out|mount)\b', ' '.join(words))]
    found = [words for words in rig if words.startswith(name)]
    assert found
    for words in found:
        assert '--params' in words, words


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_programs_and_modules_exist(page: Path) -> None:
    for target in re.findall(r'python ([a-z_/]+\.py)', read(page)):
        assert (ROOT / target).exists(), target
    for module in re.findall(r'python -m ((?:bpc_)[\w.]+)', read(page)):
        assert importlib.util.find_spec(module), module


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_scripts_named_exist(page: Path) -> None:
    names = {file.name for folder in ('test', 'docs', *(each.name for each in ROOT.glob('bpc_*')))
             for file in (ROOT / folder).rglob('*.*')}
    for name in re.findall(r'`(?:[\w/]+/)?(\w+\.(?:py|xml|msg|ino))\b', read(page)):
        assert name in names, name


def test_tests_named_exist() -> None:
    code = [each.text for each in all_code()]
    found = [re.search(r'(?:pytest|\./bpc test --)((?: [^\s]+)+)', text) for text in code]
    commands = [shlex.split(each[1]) for each in found if each]
    for arguments in commands:
        for file in arguments:
            assert not file.endswith('.py') or (ROOT / file).exists(), file
    chosen = [after for arguments in commands for option, after in pairwise(arguments)
              if option == '-k']
    assert len(chosen) >= 3
    for part in chosen:
        assert any(part in test for test in TESTS), part


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_launch_files_and_their_arguments_exist(page: Path) -> None:
    for package, file, rest in re.findall(r'ros2 launch (\w+) (\w+\.launch\.py)(.*)', read(page)):
        for argument in re.findall(r'(\w+):=', rest):
            known = launch_arguments(ROOT / package / 'launch' / file)
            assert argument in known, (file, argument)


def test_arguments_of_the_live_launch_file_exist() -> None:
    named = re.findall(r'`(\w+):=', section(INSTALLED, 'Arguments of live.launch.py'))
    assert len(named) >= 8
    assert set(named) <= launch_arguments(LIVE_LAUNCH)
    assert len(re.findall('ros2 launch', read(INSTALLED))) >= 3


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_executables_exist(page: Path) -> None:
    for package, executable in re.findall(r'ros2 run (bpc_\w+) (\w+)', read(page)):
        setup = (ROOT / package / 'setup.py').read_text(encoding='utf-8')
        assert f"'{executable} = {package}." in setup, executable


@pytest.mark.parametrize('package', ['bpc_perception', 'bpc_sim'])
def test_launched_nodes_are_installed(package: str) -> None:
    setup = (ROOT / package / 'setup.py').read_text(encoding='utf-8')
    launched: set[str] = set()
    for path in ROOT.glob('bpc_*/launch/*.launch.py'):
        text = path.read_text(encoding='utf-8')
        compile(text, path, 'exec')
        if package == 'bpc_sim':
            text = ''.join(re.findall(r"package='bpc_sim', executable='\w+'", text))
        else:
            text = re.sub(r"package='(bpc_sim|zivid_camera)', executable='\w+'", '', text)
        launched |= set(re.findall(r"executable='(\w+)'", text))
    assert launched
    for executable in launched:
        assert f"'{executable} = {package}." in setup, executable


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_code_within_lines_is_closed(page: Path) -> None:
    for paragraph in without_blocks(read(page)).split('\n\n'):
        assert paragraph.count('`') % 2 == 0, paragraph
