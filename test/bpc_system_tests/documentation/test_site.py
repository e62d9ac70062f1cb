"""The documentation becomes a web site without a warning, a network or a page left out."""

from __future__ import annotations

from pathlib import Path
import re
import subprocess
import sys
from urllib.parse import unquote

import pytest

from bpc_system_tests.documentation.pages import INDEX, links, PAGES, ROOT

BUILD_TIMEOUT_S = 90
# What a browser fetches by itself, beside what a style sheet names.
FETCHED = re.compile(r'<(?:link|script|img|source|iframe|object|video)\b[^>]*>')


def build(source: Path, folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Build a site strictly: every warning is an error."""
    return subprocess.run(
        [sys.executable, '-m', 'sphinx', '-W', '--keep-going', '-q', *options, '-c',
         str(ROOT / 'docs'), str(source), str(folder)], capture_output=True, text=True,
        timeout=BUILD_TIMEOUT_S, check=False)


@pytest.fixture(scope='module')
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site of all pages."""
    folder = tmp_path_factory.mktemp('site')
    built = build(ROOT, folder)
    assert (built.returncode, built.stderr) == (0, '')
    return folder


def html_of(site: Path, page: Path) -> Path:
    """Return the file that a page became."""
    return site / page.relative_to(ROOT).with_suffix('.html')


def write_pages(folder: Path, index: str, **pages: str) -> None:
    """Write an index page and others beside it."""
    (folder / 'docs').mkdir()
    (folder / 'docs' / 'index.md').write_text(index)
    for name, text in pages.items():
        (folder / 'docs' / f'{name}.md').write_text(text)


def test_every_page_is_in_the_site_and_in_its_navigation(site: Path) -> None:
    index = html_of(site, INDEX)
    navigation = re.findall(r'toctree-l\d[^>]*><a class="reference internal" href="([^"#]+)"',
                            index.read_text(encoding='utf-8'))
    found = {(index.parent / target).resolve() for target in navigation}
    assert found | {index} == {html_of(site, page) for page in PAGES}


def test_a_file_linked_to_is_in_the_site_byte_for_byte(site: Path) -> None:
    linked = {(page.parent / target.partition('#')[0]).resolve() for page in PAGES
              for target in links(page) if not target.startswith('#')}
    files = [file for file in linked if file.is_file() and file.suffix != '.md']
    assert {'.msg', '.xml', '.yaml', '.py', '.ino', '.png', '.jpg'} <= {
        file.suffix for file in files}
    carried = {file.name: file for folder in ('_downloads', '_images')
               for file in (site / folder).rglob('*')}
    for file in files:
        assert carried[file.name].read_bytes() == file.read_bytes(), file


def test_no_link_of_the_site_is_dead(site: Path) -> None:
    for page in PAGES:
        html = html_of(site, page)
        for target in re.findall(r'href="([^"#?]+)', html.read_text(encoding='utf-8')):
            assert '://' in target or (html.parent / unquote(target)).exists(), (page, target)


def test_the_site_fetches_nothing(site: Path) -> None:
    for file in site.rglob('*.html'):
        for tag in FETCHED.findall(file.read_text(encoding='utf-8')):
            assert '//' not in tag, (file, tag)
    for file in site.rglob('*.css'):
        for target in re.findall(r'(?:url\(|@import )["\']?([^)"\']+)', file.read_text('utf-8')):
            assert target.startswith('data:') or '//' not in target, (file, target)


@pytest.mark.parametrize(('wrong', 'warned'), [
    ('[dead](nowhere.md)', 'nowhere'), ('[dead](other.md#nowhere)', 'nowhere'),
    ('![dead](nowhere.png)', 'nowhere'), ('[dead](../nowhere.xml)', 'nowhere')])
def test_a_dead_link_is_an_error(tmp_path: Path, wrong: str, warned: str) -> None:
    write_pages(tmp_path, f'# Index\n\n{wrong}\n\n## Pages\n\n- [Other](other.md): it\n',
                other='# Other\n')
    built = build(tmp_path, tmp_path / 'site')
    assert built.returncode != 0
    assert warned in built.stderr


def test_a_page_that_the_index_lacks_is_an_error(tmp_path: Path) -> None:
    write_pages(tmp_path, '# Index\n\n## Pages\n\n- [Other](other.md): it\n',
                other='# Other\n', third='# Third\n')
    built = build(tmp_path, tmp_path / 'site')
    assert built.returncode != 0
    assert 'third.md: WARNING' in built.stderr
