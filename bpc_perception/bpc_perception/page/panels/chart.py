"""Thickness along the path, with its legend."""

from __future__ import annotations

from collections.abc import Callable
import math

from nicegui import ui
import numpy as np

from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.display.legend import as_shown, HEIGHT_COLOUR, STATUS_COLOURS
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.wording import cause_in_words, label, MEANINGS
from bpc_perception.page import elements
from bpc_perception.page.board import TargetBand
from bpc_perception.page.chart import MEASURED_COLOUR, options, TARGET_GREY
from bpc_perception.page.curve import stretches, thinned

NEWEST_LENGTH_M = 0.05  # the end of the path that the close view shows
LEAST_SPAN_M = 1e-3


class ChartPanel:
    """The chart, which a switch narrows to the end of the path, and a choice to a layer.

    Args:
        on_switch: is called when a person uses either.
    """

    def __init__(self, on_switch: Callable[[], None]) -> None:
        with elements.card('chart', 'Thickness along the path') as title:
            with title:
                self._switch = ui.switch(f'newest {NEWEST_LENGTH_M * MM_PER_M:.0f} mm',
                                         on_change=on_switch).props('dense')
                self._layer = ui.select({None: 'all layers'}, value=None,
                                        on_change=on_switch).props('dense borderless')
                self._layer.visible = False
            self._chart = ui.echart({'series': []}).classes('chart')
            self._legend = ui.element('div').classes('legend')

    @property
    def newest_only(self) -> bool:
        """Whether the end of the path is shown only."""
        return bool(self._switch.value)

    def clear(self) -> None:
        """Show nothing, as before a print."""
        self._legend.clear()
        self._draw({'series': []})

    def show(self, profile: ThicknessProfile, target: TargetBand | None, dark: bool) -> None:
        """Show a profile and its target on a light or dark page."""
        start, end = self._span(profile)
        marked = [stretch for stretch in stretches(profile, start) if stretch.start < end]
        span = (start, max(end, start + LEAST_SPAN_M))
        self._draw(options(thinned(profile, start, end=end), marked, target, span, dark))
        self._show_legend({stretch.status for stretch in marked}, profile, target)

    def _span(self, profile: ThicknessProfile) -> tuple[float, float]:
        """Return from where to where the path is shown, and offer its layers to choose from."""
        layers = np.unique(profile.layer[profile.layer >= 0]).tolist()
        choices = {None: 'all layers', **{number: f'layer {number}' for number in layers}}
        if self._layer.options != choices:
            kept = self._layer.value if self._layer.value in choices else None
            self._layer.set_options(choices, value=kept)
        self._layer.visible = len(layers) > 1
        arc = profile.arc_length
        if self._layer.value is not None:
            arc = arc[profile.layer == self._layer.value]
        if not len(arc):
            return 0.0, 0.0
        start, end = (0.0 if self._layer.value is None else float(arc[0])), float(arc[-1])
        return (max(start, end - NEWEST_LENGTH_M) if self.newest_only else start), end

    def _draw(self, chart_options: dict[str, object]) -> None:
        self._chart.options.clear()
        self._chart.options.update(chart_options)
        self._chart.update()

    def _show_legend(self, statuses: set[Status], profile: ThicknessProfile,
                     target: TargetBand | None) -> None:
        self._legend.clear()
        with self._legend:
            elements.key(MEASURED_COLOUR, 'thickness ± sigma')
            if np.isfinite(profile.height).any():
                elements.key(HEIGHT_COLOUR, 'height')
            if target is not None:
                elements.key(TARGET_GREY, 'target' if math.isnan(target.dead_band)
                             else f'target ± {target.dead_band:.0%}')
            shown = as_shown(profile).status
            for status in sorted(statuses):
                share = np.mean(shown == status)
                key = elements.key(STATUS_COLOURS[status], f'{label(status)} {share:.0%}')
                key.tooltip(_meaning(status, profile))


def _meaning(status: Status, profile: ThicknessProfile) -> str:
    """Return what a status means, and its most frequent cause in a profile."""
    counts = np.bincount(profile.cause[profile.status == status], minlength=1)
    counts[Cause.NONE] = 0
    if not counts.any():
        return MEANINGS[status]
    return f'mostly, {cause_in_words(Cause(int(counts.argmax())))}'
