"""A cache of compiled kernels for one mutant: kernels compiled before, but not the ones that may contain the change."""

from __future__ import annotations

import ast
import os
import shutil
from contextlib import suppress
from pathlib import Path

from mutation.sources import PACKAGE, module_of
from stretch_bt.compiled import cache_folder

__all__ = ["seed"]

#: files that the kept views of presses depend on
_VIEWS = "simulation/membrane"


def seed(folder: Path, changed: Path) -> None:
    """Fill a folder for NUMBA_CACHE_DIR with links to what is compiled already and to views of presses."""
    known = cache_folder()
    if known is None:
        return
    stale = _built_into(changed)
    for old in known.rglob("*.nb[ic]"):
        if old.name.partition(".")[0] not in stale:
            _link(old, folder / "stretch-bt" / known.name / old.relative_to(known))
    if _VIEWS not in changed.as_posix():
        for old in (known.parent / "views").glob("*.npz"):
            _link(old, folder / "stretch-bt" / "views" / old.name)


def _link(old: Path, new: Path) -> None:
    new.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileNotFoundError):  # another process took it away to make room
        try:
            os.link(old, new)
        except OSError:  # another file system
            shutil.copy2(old, new)


def _built_into(changed: Path) -> set[str]:
    """Return the stems of the kernels that import a changed one, itself included."""
    if not changed.stem.endswith("_kernel"):
        return set()
    kernels = {module_of(path): _imports(path) for path in PACKAGE.rglob("*_kernel.py")}
    found = {module_of(changed)}
    while more := {name for name, used in kernels.items() if used & found} - found:
        found |= more
    return {name.rpartition(".")[2] for name in found}


def _imports(path: Path) -> set[str]:
    nodes = [
        node for node in ast.walk(ast.parse(path.read_bytes())) if isinstance(node, ast.ImportFrom) and node.module
    ]
    return {str(n.module) for n in nodes} | {f"{n.module}.{alias.name}" for n in nodes for alias in n.names}
