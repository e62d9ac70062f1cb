"""The pages of the documentation, and what they are made of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
import re

ROOT = Path(__file__).resolve().parents[3]
DOCS = ROOT / 'docs'
INDEX = DOCS / 'index.md'
NODE_PAGES = DOCS / 'reference' / 'nodes'
PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', ROOT / 'bags' / 'README.md',
         ROOT / 'firmware' / 'README.md', *sorted(DOCS.rglob('*.md'))]
IDS = [str(page.relative_to(ROOT)) for page in PAGES]

BLOCK = re.compile(r'^( *)```(\w*)\n(.*?)^\1```$', re.MULTILINE | re.DOTALL)
INLINE = re.compile(r'`([^`\n]+(?:\n[^`\n]+)?)`')


@dataclass(frozen=True)
class Code:
    """A piece of code in a page; ``in_block`` tells a fenced block from code within a line."""

    page: Path
    text: str
    in_block: bool


def read(page: Path) -> str:
    """Return the text of a page."""
    return page.read_text(encoding='utf-8')


def section(page: Path, heading: str) -> str:
    """Return the part of a page under a heading of the second level."""
    return read(page).split(f'\n## {heading}\n')[1].split('\n## ')[0]


def blocks(text: str, language: str) -> list[str]:
    """Return the fenced code blocks of a language."""
    return [code for _, found, code in BLOCK.findall(text) if found == language]


def without_blocks(text: str) -> str:
    """Return a text without its fenced code blocks."""
    return BLOCK.sub('', text)


def code(page: Path) -> Iterator[Code]:
    """Yield the lines of all shell blocks of a page, and all code within its lines."""
    text = read(page)
    for block in blocks(text, 'sh'):
        for line in block.replace('\\\n', ' ').splitlines():
            yield Code(page, line, True)
    for inline in INLINE.findall(without_blocks(text)):
        yield Code(page, ' '.join(inline.split()), False)


def all_code() -> list[Code]:
    """Return the code of all pages."""
    return [each for page in PAGES for each in code(page)]


def headings(page: Path) -> list[str]:
    """Return the headings of a page, without their marks."""
    return re.findall(r'^#+ (.+)$', without_blocks(read(page)), re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """Return what a link to a heading of a page may name, as code hosts make it."""
    return {re.sub(r'[^\w -]', '', heading.lower()).replace(' ', '-')
            for heading in headings(page)}


def links(page: Path) -> list[str]:
    """Return the targets of all links and pictures of a page."""
    return re.findall(r'\]\(([^)\s]+)\)', without_blocks(read(page)))


def table_rows(text: str) -> list[list[str]]:
    """Return the cells of all rows of tables, without heads and rules."""
    lines = [line for line in text.splitlines() if line.startswith('|')]
    return [[cell.strip() for cell in line.strip('|').split('|')]
            for line, after in zip(lines, [*lines[1:], ''], strict=True)
            if not line.startswith('|---') and not after.startswith('|---')]
