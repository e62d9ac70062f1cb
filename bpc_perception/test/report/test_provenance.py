"""Where results come from."""

import numpy as np

from bpc_perception.report.provenance import versions


def test_versions_name_what_can_change_a_number():
    assert set(versions()) == {'bpc', 'python', 'numpy', 'opencv', 'ros'}
    assert versions()['numpy'] == np.__version__
