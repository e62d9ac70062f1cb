"""The advice in large type, and the numbers beside it."""

from __future__ import annotations

import math

from nicegui import ui

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.display.units import S_PER_NS
from bpc_perception.display.wording import advice_headline, age_in_words, in_mm, in_percent
from bpc_perception.page import elements


class AdvicePanel:
    """What to do, what else would do, why, and how old the advice is."""

    def __init__(self) -> None:
        with ui.element('section').classes('card area-advice') as self._card:
            with ui.element('div').classes('title'):
                ui.label('Advice')
                self._age = ui.label().classes('age')
            self._headline = ui.label().classes('headline').props('role=status')
            self._otherwise = ui.label().classes('otherwise')
            self._reason = ui.label().classes('reason')

    def show(self, advice: RateAdvice | None, now_ns: int) -> None:
        """Show advice as it is at a time [ns]; None = there is none yet."""
        shown = advice_headline(advice, now_ns)
        self._headline.set_text(shown.headline)
        self._otherwise.set_text(shown.otherwise)
        self._reason.set_text(shown.reason)
        self._age.set_text('' if advice is None else
                           f'{age_in_words((now_ns - advice.stamp_ns) * S_PER_NS)} old')
        elements.set_tone(self._card, shown.tone)


class NumbersPanel:
    """Numbers of the window that the advice looks at, and of the whole print."""

    def __init__(self) -> None:
        with ui.element('section').classes('card area-numbers'):
            self._thickness = elements.number('newest thickness', 'mm', 'largest')
            self._target = elements.number('target', 'mm')
            self._deviation = elements.number('off target', '%')
            self._expected = elements.number('comes to', 'mm')
            self._mean = elements.number('mean ± deviation', 'mm')
            self._known = elements.number('known', '%')
            self._gaps = elements.number('in gaps', 'mm')

    def show_advice(self, advice: RateAdvice | None) -> None:
        """Show the numbers of the window; those of before stay where there is no advice."""
        if advice is None:
            return
        target = advice.target_thickness if advice.target_thickness > 0 else math.nan
        self._thickness.set_text(in_mm(advice.measured_thickness))
        self._target.set_text(in_mm(target))
        self._expected.set_text(in_mm(advice.expected_thickness))
        self._deviation.set_text(in_percent(advice.measured_thickness / target - 1, '+.1%'))

    def show_profile(self, profile: ThicknessProfile | None) -> None:
        """Show the numbers of the whole print; dashes where there is no profile yet."""
        if profile is None:
            for number in (self._mean, self._known, self._gaps):
                number.set_text('–')
            return
        summary = profile.summary
        self._mean.set_text(f'{in_mm(summary.thickness_mean)} ± {in_mm(summary.thickness_std)}')
        self._known.set_text(in_percent(summary.coverage, '.0%'))
        self._gaps.set_text(in_mm(summary.gap_length, 1))
