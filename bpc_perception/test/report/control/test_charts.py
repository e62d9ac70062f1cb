"""Which prints come together on a chart, in which order, and what is told of them."""

import copy
import math

from control_summaries import summary_of
import numpy as np
import pytest

from bpc_perception.core.control.rules import Rule
from bpc_perception.report.control.charts import ChartedPrint, control_groups
from bpc_perception.report.control.tables import control_tables
from bpc_perception.report.control.words import drifts, notes

# Ten steady prints, by turns 0.01 mm above and below 2 mm, then ten that are 0.05 mm thicker.
STEADY = [1.99 + 0.02 * (number % 2) for number in range(10)]
THICKER = [width + 0.05 for width in STEADY]


def charted(*summaries):
    return [ChartedPrint.of(f'n{number}', summary) for number, summary in enumerate(summaries)]


def groups_of(widths, **settings):
    return control_groups(charted(*(
        summary_of(hour, width, **settings) for hour, width in enumerate(widths))), 10)


def names(group):
    return [each.name for each in group.prints]


def test_prints_stand_in_the_order_of_time_whatever_their_names():
    group, = control_groups(charted(summary_of(3, 2.0), summary_of(1, 2.1), summary_of(2, 2.2)))
    assert names(group) == ['n1', 'n2', 'n0']
    np.testing.assert_array_equal(group.charts[0].values, (2.1, 2.2, 2.0))


@pytest.mark.parametrize('change', [
    {'advice.target_thickness': 0.001}, {'tolerance.width': 0.1}, {'method': 'paper'},
    {'advice.target_file': 'targets.csv'}, {'path_recorder.nozzle_offset': [0.0, 0.0, 0.156]}])
def test_prints_made_with_other_settings_are_never_mixed(change):
    groups = control_groups(charted(summary_of(0, 2.0), summary_of(1, 1.0, **change),
                                    summary_of(2, 2.0)))
    assert [names(group) for group in groups] == [['n0', 'n2'], ['n1']]


@pytest.mark.parametrize('change', [
    {'watch.warn_after': 0.3}, {'path_recorder.nozzle_offset': [0.0, 0.0002, 0.1503]}])
def test_what_changes_no_print_does_not_part_them(change):
    assert len(control_groups(charted(summary_of(0, 2.0), summary_of(1, 2.0, **change)))) == 1


@pytest.mark.parametrize('name', ['advice.target_file', 'design.file'])
def test_files_are_alike_where_their_contents_are(name):
    """Each recording has a copy of its own beside it, at another place."""
    prints = [summary_of(hour, 2.0, **{name: f'/prints/{hour}/vase.csv'}) | {
        'contents': {name: content}} for hour, content in enumerate('aaba')]
    groups = control_groups(charted(*prints))
    assert [names(group) for group in groups] == [['n0', 'n1', 'n3'], ['n2']]


@pytest.mark.parametrize(('samples', 'reason'), [(0, ''), (9, 'the design tells the target')])
def test_where_the_design_tells_widths_the_target_of_the_settings_is_none(samples, reason):
    """Its widths are other ones, so that Cp beside that target would be of nothing."""
    group, = control_groups(charted(*(
        summary_of(hour, width, **{'design.file': 'vase.csv'}) | {
            'design': {'width_off': {'samples': samples}}}
        for hour, width in enumerate(STEADY))))
    assert group.charts[0].capability.reason == reason


@pytest.mark.parametrize(('camera', 'groups'), [
    ({'focal_length_px': 401.0}, 1), ({'focal_length_px': 500.0}, 2), ({'width_px': 608}, 2)])
def test_another_lens_makes_another_group(camera, groups):
    other = summary_of(1, 2.0)
    other['camera'] |= camera
    assert len(control_groups(charted(summary_of(0, 2.0), other))) == groups


def test_the_same_print_counts_once():
    group, = control_groups(charted(summary_of(0, 2.0), summary_of(1, 2.1), summary_of(0, 2.0)))
    assert (names(group), group.twice) == (['n0', 'n1'], ('n2',))
    assert 'the same print as another, left out: n2' in notes(group)


def test_thicker_prints_are_told_from_the_first_on():
    """Sigma is 0.02 / 1.128 = 0.0177 mm: 11 in a row above the centre, and 5 above 2.053 mm."""
    groups = groups_of(STEADY + THICKER)
    (_, chart, words), = drifts(groups)
    assert chart.limits.upper == pytest.approx(2.0 + 3 * 0.02 / 1.128)
    assert [(alarm.rule, alarm.start, alarm.end) for alarm in chart.alarms] == [
        (Rule.HIGH_SIDE, 9, 20), (Rule.ABOVE, 11, 12), (Rule.ABOVE, 13, 14), (Rule.ABOVE, 15, 16),
        (Rule.ABOVE, 17, 18), (Rule.ABOVE, 19, 20)]
    assert words == ('width is not steady, first at print 10 of 20 (n9): 10 to 20 in a row of 9 '
                     'or more above the centre, 12 above the upper control limit, 14 above the '
                     'upper control limit, and 3 more')


def test_steady_prints_are_left_alone():
    groups = groups_of(STEADY + STEADY)
    assert list(drifts(groups)) == []
    chart = groups[0].charts[0]
    # Within 1.7 to 2.3 mm; the standard deviation is 0.01 * sqrt(20 / 19).
    assert chart.capability.cp == pytest.approx(0.6 / (6 * 0.01 * math.sqrt(20 / 19)))


@pytest.mark.parametrize(('settings', 'reason'), [
    ({'advice.target_thickness': 0.0}, 'advice.target_thickness is not set'),
    ({'tolerance.width': 0.0}, 'tolerance.width is not set'),
    ({'advice.target_file': 'targets.csv'}, 'the target changes along the path')])
def test_without_a_tolerance_there_is_a_reason_instead(settings, reason):
    group, = groups_of(STEADY, **settings)
    assert math.isnan(group.charts[0].capability.cpk)
    assert f'width: no Cp and Cpk: {reason}' in notes(group)


def test_few_prints_have_reasons_instead_of_limits():
    group, = groups_of(STEADY[:4])
    assert notes(group) == [
        'width: no control limits: limits need 10 prints, the baseline has 4',
        'width: no Cp and Cpk: Cp needs 10 prints, there are 4']


def test_the_share_of_good_prints_runs_over_those_that_are_judged():
    said = ('NOT_ENOUGH_SEEN', 'PASS', 'FAIL', 'NOT_ENOUGH_SEEN', 'PASS')
    group, = control_groups(charted(*(
        summary_of(hour, 2.0, verdict=each) for hour, each in enumerate(said))))
    np.testing.assert_allclose(group.good_share, (np.nan, 1, 1 / 2, 1 / 2, 2 / 3))


def test_a_height_has_a_chart_where_it_is_known():
    group, = control_groups(charted(summary_of(0, 2.0, 0.6), summary_of(1, None)))
    width, height = group.charts
    np.testing.assert_array_equal(width.values, (2.0, np.nan))
    np.testing.assert_array_equal(height.values, (0.6, np.nan))


@pytest.mark.parametrize('odd', [
    {'verdict': 'PASS'}, {'settings': 'none'}, {'camera': 3}, {'ink': None}, {'stamp_ns': 'now'},
    {'settings': {'path_recorder.nozzle_offset': ['a', 'b', 'c']}}])
def test_a_summary_of_another_version_is_charted_all_the_same(odd):
    group, = control_groups(charted(summary_of(0, 2.0) | odd))
    assert names(group) == ['n0']
    control_tables([group])


def test_tables_have_a_row_for_each_print_and_each_chart():
    groups = groups_of(STEADY + THICKER) + groups_of([1.0], **{'advice.target_thickness': 0.001})
    control, capability = control_tables(groups)
    assert [row['width_mm'] for row in control.rows] == [*STEADY, *THICKER, 1.0]
    alarmed = [row['number'] for row in control.rows if row['width_alarm']]
    assert alarmed == list(range(10, 21))
    assert control.rows[0]['time'] == '1970-01-01T00:00:00Z'
    steady, alone = capability.rows
    assert (steady['least_mm'], steady['target_mm'], steady['largest_mm']) == (
        pytest.approx((1.7, 2.0, 2.3)))
    assert (alone['cp'], alone['centre_mm'], alone['prints']) == (None, None, 1)
    assert alone['setup'] == 'advice.target_thickness = 0.001'
    for table in (control, capability):
        assert all(row.keys() == {column.name for column in table.columns} for row in table.rows)


def test_prints_are_not_changed_by_being_charted():
    summary = summary_of(0, 2.0)
    before = copy.deepcopy(summary)
    control_tables(control_groups(charted(summary)))
    assert summary == before
