"""The digest of the package itself: two machines whose packages differ may come to different rows."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

from stretch_bt.errors import InvalidInput

__all__ = ["another_package", "package_digest"]

#: what Python and numba write beside the source
_MADE = (".pyc", ".pyo", ".nbi", ".nbc")


@lru_cache(maxsize=1)
def package_digest() -> str:
    """Return the SHA-256 of every file of the installed package, source and data, as this process found it first."""
    root = Path(str(files("stretch_bt")))
    found = hashlib.sha256()
    for path in sorted(root.rglob("*")):
        if "__pycache__" not in path.parts and path.suffix not in _MADE and path.is_file():
            content = path.read_bytes()
            found.update(f"{path.relative_to(root).as_posix()}\0{len(content)}\0".encode())
            found.update(content)
    return found.hexdigest()


def another_package(who: str) -> InvalidInput:
    """Return the error of a process whose package has another digest."""
    what = f"{who} has another stretch_bt than the sweep"
    return InvalidInput(f"{what}; install the same version, with the same changes, there, and go on with --resume")
