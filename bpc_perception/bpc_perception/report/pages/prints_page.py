"""The page that lists the prints of a recording."""

from __future__ import annotations

from typing import Any

from bpc_perception.report.pages.page import page


def render(overview: dict[str, Any]) -> str:
    """Make the page from the content of the summary of several prints, lengths in mm."""
    return page('prints.html.j2', {}, overview=overview)
