"""Arguments of Python calls: each is of the kind that its name says, or is refused by its name."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from numbers import Integral
from typing import Any

from stretch_bt.errors import InvalidInput, shown

__all__ = ["check_arguments", "checked_seed"]


def _is_path(given: Any) -> bool:
    return isinstance(given, str | os.PathLike)


def _is_mapping(given: Any) -> bool:
    return isinstance(given, Mapping)


#: what each argument is, and what it takes
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
