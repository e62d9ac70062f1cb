"""The fault table names existing tests for every fault."""

from __future__ import annotations

import re

from bpc_system_tests.parts.command_line import ROOT

TABLES = (ROOT / 'docs' / 'reference' / 'faults.md').read_text().split('## How a fault is seen')[0]
FOLDERS = ('bootstrap', 'bpc_perception/test', 'bpc_sim/test', 'test/bpc_system_tests')
TESTS = {name for folder in FOLDERS for file in (ROOT / folder).rglob('test_*.py')
         for name in re.findall(r'^def (test_\w+)', file.read_text(), re.MULTILINE)}


def test_every_fault_names_tests_that_exist() -> None:
    rows = [[cell.strip() for cell in line.strip('|').split('|')]
            for line in TABLES.splitlines() if line.startswith('| ')]
    faults = {fault: re.findall(r'`(test_\w+)`', tests) for fault, _, tests in rows
              if fault != 'fault'}
    assert len(faults) > 40
    assert {fault for fault, tests in faults.items() if not tests} == set()
    assert {name for tests in faults.values() for name in tests} - TESTS == set()
