"""Arguments of Python calls: each is of the kind that its name says, or is refused by its name."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Estimate

__all__ = [
    "check_arguments",
    "check_counts",
    "check_each",
    "check_estimates",
    "check_kind",
    "check_numbers",
    "check_path",
    "check_unmasked",
    "checked_seed",
]

_SHOWN = 80  # characters of a given value that an error repeats


def _is_path(given: Any) -> bool:
    return isinstance(given, str | os.PathLike)


def _is_mapping(given: Any) -> bool:
    return isinstance(given, Mapping)


#: the check of each argument, and the words for the values it takes
_KINDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "tree": (_is_path, "the path or name of a tree"),
    "scene": (_is_path, "the path or name of a scene"),
    "cell": (lambda given: _is_path(given) or hasattr(given, "lend"), "the path or name of a cell, or an open cell"),
    "params": (_is_mapping, "a mapping from names of params to values"),
    "mocks": (lambda given: _is_path(given) or _is_mapping(given), "a mocks file, its text, or a mapping"),
    "out": (_is_path, "the path of a folder"),
    "devices": (_is_mapping, "a mapping from names to devices"),
    "modules": (_is_path, "the path of a folder"),
    "record": (lambda given: isinstance(given, str), "'full', 'events' or 'none'"),
    "tolerance": (_is_mapping, "a mapping, as in {'stiffness': '2 %'}"),
    "file": (_is_path, "the path of a file or the name of a shipped tree"),
}
_NEEDED = ("tree", "record", "file")


def check_arguments(**given: Any) -> None:
    """Raise InvalidInput for the first argument that is of another kind than its name says; most may be None."""
    for name, value in given.items():
        fits, kind = _KINDS[name]
        if not (fits(value) or (value is None and name not in _NEEDED)):
            raise InvalidInput(f"{name} takes {kind}, not {shown(value)}")


def checked_seed(seed: Any) -> int:
    """Return a seed as Python's own number; raises InvalidInput unless it is a whole number from 0 on."""
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise InvalidInput(f"a seed is a whole number from 0 on, not {shown(seed)}")
    return int(seed)


def check_kind(what: str, given: object, kind: type, made: str = "") -> None:
    """Raise InvalidInput unless an argument is of a class; `made` says what makes one."""
    if not isinstance(given, kind):
        raise InvalidInput(f"{what} is a {kind.__name__}, not {_brief(given)}{made and '; '}{made}")


def check_each(what: str, given: object, kind: type, made: str = "") -> None:
    """Raise InvalidInput unless an argument is a list, or another sequence, of a class."""
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise InvalidInput(f"{what} are a list of {kind.__name__}, not {_brief(given)}{made and '; '}{made}")
    for one in given:
        check_kind(f"each of {what}", one, kind, made)


def check_numbers(unit: str, **given: object) -> None:
    """Raise InvalidInput for the first argument that is no finite number, of Python or numpy."""
    for name, value in given.items():
        if not is_number(value):
            text = "; text with a unit is for trees and commands" if isinstance(value, str) else ""
            raise InvalidInput(f"{name} is a finite number{unit and ', '}{unit}, not {_brief(value)}{text}")


def check_path(path: object) -> None:
    """Raise InvalidInput unless something is the path of a file, text or one of `pathlib`, without a null character."""
    if not _is_path(path):
        raise InvalidInput(f"path is the path of a file, not {_brief(path)}")
    if "\0" in str(path):
        raise InvalidInput(f"path is the path of a file, without a null character, not {_brief(path)}; leave it out")


def check_counts(least: int, **given: object) -> None:
    """Raise InvalidInput for the first argument that is no whole number, or is below the least."""
    for name, value in given.items():
        if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < least:
            raise InvalidInput(f"{name} is a whole number from {least} on, not {_brief(value)}")


def check_unmasked(said: str, given: object, give: str = "array.filled(numpy.nan)") -> None:
    """Raise InvalidInput, which begins with `said`, for an array with a mask of its own, which nothing here would heed."""
    if isinstance(given, np.ma.MaskedArray):
        raise InvalidInput(f"{said} an array without a mask, got a masked one; give {give}")


def check_estimates(**given: object) -> None:
    """Raise InvalidInput for the first argument that does not carry its standard deviation, or whose numbers are not finite."""
    for name, value in given.items():
        if not isinstance(value, Estimate):
            raise InvalidInput(
                f"{name} is an Estimate, a value with its standard deviation, not {_brief(value)}; write Estimate(value, sd) of"
                " stretch_bt.units"
            )
        if not (is_number(value.value) and is_number(value.sd) and value.sd >= 0):
            raise InvalidInput(f"{name} must be finite with a standard deviation of 0 or more, not {value}")


def _brief(given: object) -> str:
    text = " ".join(shown(given).split())
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}... (a {type(given).__name__})"
