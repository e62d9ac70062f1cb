"""Where results come from."""

import numpy as np

from bpc_perception.core.config import AdviceConfig, DesignConfig, ThicknessConfig
from bpc_perception.report.provenance import contents_of, versions


def test_versions_name_what_can_change_a_number():
    assert set(versions()) == {'bpc', 'python', 'numpy', 'opencv', 'ros'}
    assert versions()['numpy'] == np.__version__


def test_contents_tell_copies_of_a_file_from_others_and_leave_out_what_is_gone(tmp_path):
    def of(text):
        file = tmp_path / f'{len(list(tmp_path.iterdir()))}.csv'
        file.write_text(text)
        return contents_of(ThicknessConfig(
            design=DesignConfig(file=str(file)),
            advice=AdviceConfig(target_file=str(tmp_path / 'gone.csv'))))

    assert of('one') == of('one') != of('another')
    assert list(of('one')) == ['design.file']
