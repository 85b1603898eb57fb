"""The benchmarks of the membrane, whose drawing and fitting the tests share."""

import importlib.util
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


def loaded(name):
    spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def trends():
    return loaded("membrane_trends")


@pytest.fixture(scope="session")
def random_presses():
    return loaded("membrane_random")
