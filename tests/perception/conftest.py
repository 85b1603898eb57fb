"""The analytic surfaces of the benchmarks, and the real recordings where they are at hand."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def surfaces():
    path = ROOT / "benchmarks" / "perception_surfaces.py"
    spec = importlib.util.spec_from_file_location("perception_surfaces", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def data():
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the real recordings are not on this machine")
    return folder
