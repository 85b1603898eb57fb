"""The analytic surfaces, and the real recordings where they are at hand."""

from pathlib import Path

import pytest

from stretch_bt.accuracy.perception import analytic

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def surfaces():
    return analytic


@pytest.fixture(scope="session")
def data():
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the real recordings are not on this machine")
    return folder
