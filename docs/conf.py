"""The web site of the documentation: ``sphinx-build -c docs . site`` in the repository's root.

The pages are read from the root, not from ``docs``. So the README and its neighbours are pages as
well, and a relative link works in the site as it does on a code host. Files that are no pages,
such as a message, are added to the site where a page links to them; MyST does that.
"""

from __future__ import annotations

import re

from sphinx.application import Sphinx

from bpc_perception import __version__

project = 'bpc'
version = release = __version__
language = 'en'

extensions = ['myst_parser']
root_doc = 'docs/index'
include_patterns = ['README.md', 'CONTRIBUTING.md', 'bags/README.md', 'firmware/README.md',
                    'docs/**.md']
exclude_patterns = ['.*', 'build', 'install', 'log', 'site', 'demo', 'replay', '**/node_modules']
myst_heading_anchors = 3  # deepest heading that a link may name
smartquotes = False  # what is written is shown
nitpicky = True  # a reference without a target is a warning

html_theme = 'furo'
html_title = 'bpc'
html_static_path = ['style']
html_css_files = ['tables.css']
html_copy_source = False
html_show_copyright = False

PAGE = re.compile(r'^- \[([^]]+)\]\((\S+)\.md\)', re.MULTILINE)


def add_navigation(_: Sphinx, page: str, source: list[str]) -> None:
    """Make the navigation from the lists of the index page, one part for each section."""
    if page != root_doc:
        return
    for section in source[0].split('\n## ')[1:]:
        caption, _, text = section.partition('\n')
        if pages := '\n'.join(f'{title} <{path}>' for title, path in PAGE.findall(text)):
            source[0] += f'\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{pages}\n```\n'


def setup(app: Sphinx) -> None:
    """Connect the hook."""
    app.connect('source-read', add_navigation)
