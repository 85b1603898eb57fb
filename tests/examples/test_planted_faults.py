"""Faults planted in copies of the example drivers are found by the clause that is meant for them, in words."""

import re

import pytest
from planted_faults import FAULTS, fails, planted

pytest.importorskip("rosbags.rosbag2")

TRIES = 3


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_planted_fault_is_found_and_named(fault, tmp_path):
    with planted(fault, fault.package, tmp_path) as contract:
        # a machine that is late may look at a motion when the device has reported its end already
        said = next((said for _ in range(TRIES) if (said := fails(contract, fault.clause)) is not None), None)
    assert said is not None, "the clause finds nothing"
    assert re.search(fault.words, said), said


def test_there_are_seventeen():
    assert len(FAULTS) == 17
    assert len({fault.name for fault in FAULTS}) == 17
