"""Copies of files that a run uses: its record names the originals, which are there when the copies are gone."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

__all__ = ["copies_of", "copy_of", "named_by_originals"]

#: the folder of the copies, and that of the originals; texts alike where there are no copies
_folders: ContextVar[tuple[str, str]] = ContextVar("_folders", default=("", ""))


@contextmanager
def copies_of(originals: str, copies: Path) -> Iterator[None]:
    """Let runs know that files in the folder `copies` are copies of those in another folder, which may be on another machine."""
    token = _folders.set((str(copies), originals))
    try:
        yield
    finally:
        _folders.reset(token)


def named_by_originals(value: Any) -> Any:
    """Return JSON's own types with the path of the original where a text is the path of a copy; keys stay."""
    if isinstance(value, str):
        return _moved(value, *_folders.get())
    if isinstance(value, dict):
        return {name: named_by_originals(item) for name, item in value.items()}
    return [named_by_originals(item) for item in value] if isinstance(value, list) else value


def copy_of(path: str) -> str:
    """Return the path of the copy of a file, or the path itself where there is none."""
    copies, originals = _folders.get()
    return _moved(path, originals, copies)


def _moved(path: str, old: str, new: str) -> str:
    """Return a path in another folder, or as it is where it is not in the old one."""
    before, after = (folder.rstrip(os.sep) + os.sep for folder in (old, new))
    return after + path.removeprefix(before) if old != new and path.startswith(before) else path
