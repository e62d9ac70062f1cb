"""The shell that all pages share, and how numbers are written on them."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timezone
import math

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from bpc_perception.display.units import NS_PER_S

NS_PER_MS = 10**6


def page(template: str, figures: Mapping[str, go.Figure], **content: object) -> str:
    """Make a page from a template, figures by name, and the other variables of the template."""
    environment = Environment(
        loader=PackageLoader('bpc_perception.report.pages'), autoescape=True,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(number=number, mm=mm, share=share, utc=utc)
    return environment.get_template(template).render(
        # The library's own script, which is large.
        plotly=Markup(get_plotlyjs() if figures else ''),  # noqa: S704
        figures={name: _embed(name, figure) for name, figure in figures.items()}, **content)


def _embed(name: str, figure: go.Figure) -> Markup:
    """Return a figure as HTML that fills the element around it."""
    html = figure.to_html(
        full_html=False, include_plotlyjs=False, div_id=f'{name}-figure',
        default_width='100%', default_height='100%',
        # Plotly has a button that uploads the data; measurements stay where they are.
        config={'showSendToCloud': False, 'displaylogo': False,
                'modeBarButtonsToRemove': ['select2d', 'lasso2d'],
                'responsive': True, 'scrollZoom': name == 'image'})
    return Markup(html)  # noqa: S704 (Plotly escapes what is in the figure)


def number(value: float | None, digits: int = 3) -> str:
    """Return a number of the summary for reading; a dash for none."""
    return '-' if value is None or math.isnan(value) else f'{value:.{digits}f}'


def mm(value: float | None, digits: int = 3) -> str:
    """Return a length [mm] with its unit; a dash for none."""
    return '-' if value is None else f'{number(value, digits)} mm'


def share(value: float | None) -> str:
    """Return a share in percent; a dash for none."""
    return '-' if value is None else f'{number(100 * value, 1)} %'


def utc(stamp_ns: int) -> str:
    """Return a stamp [ns] as date and time of day, to the millisecond."""
    seconds, rest_ns = divmod(stamp_ns, NS_PER_S)
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return f'{moment:%Y-%m-%d %H:%M:%S}.{rest_ns // NS_PER_MS:03d} UTC'
