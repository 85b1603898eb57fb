"""One table of hard inputs, each with its expected outcome; the rows are in hard_cases/, a module for each part.

A module has CASES: {name: (call, expected)}. `expected` is (error class, pattern) where the call must raise, or warn if
the class is a warning; a function that asserts what it is given; or else a value to compare with.
"""

import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent / "hard_cases"


def rows():
    for path in sorted(FOLDER.glob("*.py")):
        spec = importlib.util.spec_from_file_location(f"hard_cases_{path.stem}", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        for name, (call, expected) in module.CASES.items():
            yield pytest.param(call, expected, id=f"{path.stem}: {name}")


@pytest.mark.parametrize(("call", "expected"), list(rows()))
def test_a_hard_input_ends_as_expected(call, expected):
    if isinstance(expected, tuple) and isinstance(expected[0], type):
        kind, pattern = expected
        catching = pytest.warns if issubclass(kind, Warning) else pytest.raises
        with catching(kind, match=pattern):
            call()
    elif callable(expected):
        expected(call())
    else:
        assert call() == expected
