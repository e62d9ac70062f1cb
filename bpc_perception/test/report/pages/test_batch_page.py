"""The page of a batch: its prints with links, those that failed, and charts of groups."""

from control_summaries import summary_of

from bpc_perception.report.control.charts import ChartedPrint, control_groups
from bpc_perception.report.pages import batch_page


def row(out, name, **values):
    return {'bag': name, 'exit_status': 0, 'results': str(out / name), 'print': 1,
            'verdict': 'PASS', 'path_length_mm': 50.0, 'coverage': 1.0, 'thickness_mean_mm': 2.0,
            'thickness_std_mm': 0.1, 'height_mean_mm': None, 'within_10_percent': 1.0,
            'gap_count': 0, 'reason': '', **values}


def page_of(tmp_path, rows, *summaries):
    groups = control_groups(ChartedPrint.of(f'n{number}', summary)
                            for number, summary in enumerate(summaries))
    return batch_page.render(tmp_path, rows, groups)


def test_names_stay_text_and_links_lead_to_reports(tmp_path):
    page = page_of(tmp_path, [row(tmp_path, 'a/<b> 1')], summary_of(0, 2.0))
    assert 'href="a/%3Cb%3E%201/report.html"' in page
    assert 'a/&lt;b&gt; 1' in page
    assert '<b>' not in page
    assert "default-src 'none'" in page


def test_a_batch_in_which_all_failed_tells_why(tmp_path):
    rows = [row(tmp_path, 'a', exit_status=2, reason='no capture', verdict=None)]
    page = page_of(tmp_path, rows)
    assert 'no capture' in page
    assert 'Over the prints' not in page


def test_two_prints_are_no_chart(tmp_path):
    page = page_of(tmp_path, [row(tmp_path, 'a')], summary_of(0, 2.0), summary_of(1, 2.0))
    assert 'drawn as a control chart; there are none' in page
    assert 'control1-figure' not in page


def test_groups_are_drawn_apart_with_what_parts_them(tmp_path):
    thin = {'advice.target_thickness': 0.001}
    page = page_of(tmp_path, [row(tmp_path, 'a')], *(
        summary_of(hour, 2.0) for hour in range(3)), *(
        summary_of(hour, 1.0, **thin) for hour in range(3, 6)), summary_of(7, 2.0, method='paper'))
    assert 'id="control1-figure"' in page
    assert 'id="control2-figure"' in page
    assert 'id="control3-figure"' not in page
    assert 'group 3, 1 print<' in page
    head, rest = page.split('<th>advice.target_thickness</th>')
    assert [cell in rest.split('</tr>')[0] for cell in ('>0.002<', '>0.001<')] == [True, True]
    assert 'limits need 10 prints, the baseline has 3' in head
