"""The report: carries everything it shows, and says it in words."""

import base64
from html.parser import HTMLParser
import json

import pytest
from report_prints import NASTY

from bpc_perception.core.result import Result
from bpc_perception.core.targets import WidthTargets
from bpc_perception.report.pages import report_page
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import Provenance
from bpc_perception.report.summary import summarize
from bpc_perception.report.thumbnails import decode

MM = 1e-3
TARGETS = WidthTargets.constant(2.078 * MM)


def rendered(result):
    log = PrintLog.of([Result(result.capture, refusal='no <deposit>'), result])
    return report_page.render(log, summarize(log, Provenance(
        f'{NASTY}.mcap', 'cell.calib', {'advice.dead_band': 0.03}, {'bpc': '0.1.0'}, TARGETS)),
        TARGETS)


@pytest.fixture
def page(result):
    return rendered(result)


class Elements(HTMLParser):
    """Every start tag with its attributes, and the text outside of scripts and styles."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.text = [], ''
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.tags[-1:] and self.tags[-1][0] not in ('script', 'style'):
            self.text += data


def picture(source):
    return decode(base64.b64decode(source.split(',')[1]))


def test_page_loads_nothing(page):
    tags = Elements(page).tags
    assert not [tag for tag in tags
                if tag[0] in ('link', 'iframe', 'img', 'object', 'embed', 'base')]
    assert not [tag for tag in tags if {'src', 'href'} & tag[1].keys()]
    policy = next(attributes['content'] for _, attributes in tags
                  if attributes.get('http-equiv') == 'Content-Security-Policy')
    assert policy.startswith("default-src 'none'")
    assert 'http' not in policy


def test_page_cannot_send_the_data_away(page):
    assert page.count('"showSendToCloud": false') == 5


def test_nasty_names_stay_text(page):
    assert NASTY not in page
    assert f'Thickness of print {NASTY}' in Elements(page).text
    assert f'{NASTY}.mcap' in Elements(page).text


def test_page_says_the_numbers(page):
    text = Elements(page).text
    for words in ('2.000 mm',
                  'flow x 1.08, or else speed x 0.93: what is laid now comes out too thin',
                  '100.0 %', '1, together 1.0 mm', 'no <deposit>',
                  'advice.dead_band', 'cell.calib', '1970-01-01 00:00:01.000 UTC'):
        assert words in text


def test_page_is_small(page):
    assert len(page.encode()) < 6e6


def test_same_result_same_page(page, result):
    assert page == rendered(result)


def test_page_leafs_through_the_captures(page):
    # The text is in a script element; tojson keeps it from ending that element.
    frames = json.loads(page.split('id="frames">')[1].split('</script>')[0])
    refused, reported = frames
    assert refused['words'] == 'refused: no <deposit>'
    assert picture(refused['source']).shape == (4 * 24, 4 * 32, 3)
    assert (reported['capture'], reported['source']) == (0, '')
    assert reported['words'] == '2.000 mm ± 0.000 mm, 100.0 % known'
