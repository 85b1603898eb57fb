"""Faults planted in copies of the example drivers are found by the clause that is meant for them, in words."""

import re

import pytest
from planted_faults import FAULTS, fails, planted

pytest.importorskip("rosbags.rosbag2")


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_planted_fault_is_found_and_named(fault, tmp_path):
    with planted(fault, fault.package, tmp_path) as contract:
        said = fails(contract, fault.clause)
    assert said is not None, "the clause finds nothing"
    assert re.search(fault.words, said), said


def test_there_are_seventeen():
    assert len(FAULTS) == 17
    assert len({fault.name for fault in FAULTS}) == 17
