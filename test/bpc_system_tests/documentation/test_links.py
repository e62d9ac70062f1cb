"""Every link leads to a file and a heading that exist, and every page is found from the index."""

from __future__ import annotations

from pathlib import Path
import re

import cv2
import pytest

from bpc_perception.core.profile import Status
from bpc_perception.messages import topics
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_system_tests.documentation import message_tables
from bpc_system_tests.documentation.pages import (
    anchors,
    blocks,
    DOCS,
    headings,
    IDS,
    INDEX,
    links,
    PAGES,
    read,
    ROOT,
    without_blocks,
)

README = ROOT / 'README.md'
PICTURES = DOCS / 'pictures'


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_files_linked_to_exist(page: Path) -> None:
    for target in links(page):
        path = target.partition('#')[0]
        assert '://' in target or (page.parent / path).resolve().exists(), target


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_headings_linked_to_exist(page: Path) -> None:
    for target in links(page):
        path, _, anchor = target.partition('#')
        other = (page.parent / path).resolve() if path else page
        assert not anchor or anchor in anchors(other), target


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_no_heading_comes_twice_in_a_page(page: Path) -> None:
    found = headings(page)
    assert len(found) == len(set(found))
    assert len(re.findall(r'^# ', without_blocks(read(page)), re.MULTILINE)) == 1


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_every_page_is_linked_from_the_index(page: Path) -> None:
    found = {(INDEX.parent / target.partition('#')[0]).resolve() for target in links(INDEX)}
    assert page == INDEX or page in found


def test_the_index_is_linked_from_the_readme() -> None:
    assert 'docs/index.md' in links(README)


@pytest.mark.parametrize('name', [
    *(status.name for status in Status), *(file.stem for file in message_tables.FILES),
    topics.PROFILE, topics.ADVICE, 'profile.csv', 'summary.json', 'report.html', 'compare.html',
    'prints.csv', 'hand_eye.calib', 'params.yaml'])
def test_a_name_can_be_looked_up(name: str) -> None:
    assert f'`{name}`' in read(INDEX).split('\n## Look up a name\n')[1]


@pytest.mark.parametrize('package', ['bpc_perception', 'bpc_sim'])
def test_every_node_can_be_looked_up(package: str) -> None:
    setup = (ROOT / package / 'setup.py').read_text(encoding='utf-8')
    nodes = re.findall(rf"'(\w+) = {package}\.nodes\.\w+:main'", setup)
    assert len(nodes) >= 5
    for node in nodes:
        assert f'`{node}`' in read(INDEX).split('\n## Look up a name\n')[1], node


def test_the_readme_is_short() -> None:
    assert len(read(README).splitlines()) <= 240


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_lines_are_short_outside_tables_and_blocks(page: Path) -> None:
    for line in without_blocks(read(page)).splitlines():
        assert len(line) <= 120 or line.startswith('|'), line


@pytest.mark.parametrize('page', PAGES, ids=IDS)
def test_code_blocks_name_their_language(page: Path) -> None:
    known = [blocks(read(page), language) for language in ('sh', 'text', 'yaml')]
    assert sum(map(len, known)) == len(re.findall(r'^ *```\w*$', read(page), re.MULTILINE)) / 2


def test_every_scenario_is_described() -> None:
    text = read(DOCS / 'reference' / 'commands.md').split('\n## Scenarios\n')[1].split('\n## ')[0]
    for scenario in SCENARIOS:
        assert f'`{scenario}`' in text, scenario


def test_every_status_is_described() -> None:
    for status in Status:
        assert f'\n| `{status.name}` |' in read(DOCS / 'explanation' / 'statuses.md'), status


@pytest.mark.parametrize('picture', sorted(PICTURES.iterdir()), ids=lambda path: str(path.name))
def test_pictures_are_small(picture: Path) -> None:
    assert picture.stat().st_size < 200_000
    image = cv2.imread(str(picture))
    assert image is not None
    assert min(image.shape[:2]) > 300


def test_every_picture_is_shown() -> None:
    shown = {(page.parent / target).resolve() for page in PAGES for target in links(page)}
    assert set(PICTURES.iterdir()) <= shown
