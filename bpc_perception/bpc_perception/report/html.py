"""The report of a measurement: one HTML file that opens anywhere, without a network."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timezone
import math
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.profile import Status
from bpc_perception.display.legend import COLOURS
from bpc_perception.display.wording import advice_in_words, label, MEANINGS
from bpc_perception.report.figures import (
    data_uri,
    histogram_figure,
    image_figure,
    map_figure,
    offset_figure,
    thickness_figure,
)
from bpc_perception.report.print_log import PrintLog


def render(log: PrintLog, summary: dict[str, Any], targets: WidthTargets | None = None) -> str:
    """The page about a measured result.

    Args:
        log: with a result to report.
        summary: content of summary.json, lengths in mm.
        targets: the thickness wanted along the path; None = none.
    """
    result = log.reported
    assert result is not None
    profile, advice = result.profile, result.advice
    assert profile is not None
    assert advice is not None
    leaves = frames(log)
    return page(
        'report.html.j2',
        {'image': image_figure(result),
         'thickness': thickness_figure(result, targets,
                                       float(summary['settings'].get('advice.dead_band', 0))),
         'offset': offset_figure(profile),
         'map': map_figure(profile, targets),
         'histogram': histogram_figure(profile, targets)},
        summary=summary, advice_words=advice_in_words(advice),
        statuses=[(status.name, label(status), COLOURS[status], MEANINGS[status])
                  for status in Status],
        aspect=f'{result.capture.camera.width} / {result.capture.camera.height}',
        reference='median' if targets is None else 'target',
        frames=leaves, shown=next(number for number, leaf in enumerate(leaves)
                                  if not leaf['source']))


def frames(log: PrintLog) -> list[dict[str, object]]:
    """The pictures to leaf through, of the capture reported without one: it is drawn in full."""
    found = []
    for place in sorted({*log.thumbnails.pictures, log.place}):
        each = log.entries[place]
        told = ({'words': f'refused: {each["refusal"]}'} if 'refusal' in each else
                {'words': f'{_mm(each["thickness_mean_mm"])} ± '
                          f'{_mm(each["thickness_std_mm"])}, {_share(each["coverage"])} known',
                 'capture': each['capture']})
        picture = '' if place == log.place else data_uri(log.thumbnails.pictures[place], 'webp')
        found.append({**told, 'time': _utc(each['stamp_ns']), 'source': picture})
    return found


def page(template: str, figures: Mapping[str, go.Figure], **content: object) -> str:
    """A page that holds all it needs, made of a template and figures by name."""
    environment = Environment(
        loader=PackageLoader('bpc_perception.report'), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(number=_number, mm=_mm, share=_share, utc=_utc)
    return environment.get_template(template).render(
        plotly=Markup(get_plotlyjs()),  # noqa: S704 (the library's own script)
        figures={name: _embed(name, figure) for name, figure in figures.items()}, **content)


def _embed(name: str, figure: go.Figure) -> Markup:
    """The figure as HTML that fills the element around it."""
    html = figure.to_html(
        full_html=False, include_plotlyjs=False, div_id=f'{name}-figure',
        default_width='100%', default_height='100%',
        # Plotly has a button that uploads the data; measurements stay where they are.
        config={'showSendToCloud': False, 'displaylogo': False,
                'modeBarButtonsToRemove': ['select2d', 'lasso2d'],
                'responsive': True, 'scrollZoom': name == 'image'})
    return Markup(html)  # noqa: S704 (Plotly escapes what is in the figure)


def _number(value: float | None, digits: int = 3) -> str:
    """A number of the summary for reading; a dash for none."""
    return '-' if value is None or math.isnan(value) else f'{value:.{digits}f}'


def _mm(value: float | None, digits: int = 3) -> str:
    return '-' if value is None else f'{_number(value, digits)} mm'


def _share(value: float | None) -> str:
    """A share in percent."""
    return '-' if value is None else f'{_number(100 * value, 1)} %'


def _utc(stamp_ns: int) -> str:
    """A stamp as date and time of day, to the millisecond."""
    seconds, rest = divmod(stamp_ns, 10**9)
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return f'{moment:%Y-%m-%d %H:%M:%S}.{rest // 10**6:03d} UTC'
