"""Every benchmark can be begun."""

import importlib
import pkgutil

import pytest

import benchmarks

NAMES = sorted(m.name for m in pkgutil.iter_modules(benchmarks.__path__) if not m.ispkg)


@pytest.mark.parametrize("name", NAMES)
def test_a_benchmark_is_imported(name):
    importlib.import_module(f"benchmarks.{name}")
