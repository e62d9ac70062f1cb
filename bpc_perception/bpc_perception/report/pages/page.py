"""The shell that all pages share, and how numbers are written on them."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timezone
import math

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bpc_perception.display.units import NS_PER_S
from bpc_perception.report.figures.figure import Figure, packaged, typed_array

NS_PER_MS = 10**6


def page(template: str, figures: Mapping[str, Figure], **content: object) -> str:
    """Make a page from a template, figures by name, and the other variables of the template."""
    environment = Environment(
        loader=PackageLoader('bpc_perception.report.pages'), autoescape=True,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(number=number, mm=mm, share=share, utc=utc)
    environment.policies['json.dumps_kwargs'] = {'sort_keys': True, 'default': typed_array}
    return environment.get_template(template).render(
        # The library's own script, which is large.
        plotly=Markup(packaged('plotly.min.js') if figures else ''),  # noqa: S704
        figures={name: _embed(environment, name, figure) for name, figure in figures.items()},
        **content)


def _embed(environment: Environment, name: str, figure: Figure) -> Markup:
    """Return a figure as HTML that fills the element around it."""
    html = environment.get_template('figure.html.j2').render(
        place=f'{name}-figure', figure=figure,
        # Plotly has a button that uploads the data; measurements stay where they are.
        config={'showSendToCloud': False, 'displaylogo': False,
                'modeBarButtonsToRemove': ['select2d', 'lasso2d'],
                'responsive': True, 'scrollZoom': name == 'image'})
    return Markup(html)  # noqa: S704 (the template escapes what is in the figure)


def number(value: float | None, digits: int = 3) -> str:
    """Return a number of the summary for reading; a dash for none."""
    if value is None or math.isnan(value):
        return '-'
    return f'{round(value, digits) + 0.0:.{digits}f}'  # no minus in front of 0


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
