"""The makers of a row: processor, commit and versions."""

from __future__ import annotations

import platform
import subprocess
from pathlib import Path
from typing import NamedTuple

import stretch_bt

__all__ = ["Made", "made_here"]

_DESCRIBE = ("describe", "--always", "--abbrev=12", "--exclude=*", "--dirty=+")


class Made(NamedTuple):
    """Model name of the processor; commit, with a + where files were changed since, None where git knows none; versions."""

    cpu: str
    commit: str | None
    versions: dict[str, str]


def made_here(commit: str | None = None) -> Made:
    """Return the makers of rows here; `commit` where git does not know."""
    from stretch_bt.runtime.prepare import versions
    from stretch_bt.runtime.provenance import processor

    known = versions("stretch-bt", "numpy", "scipy", "numba") | {"python": platform.python_version()}
    return Made(processor(), commit or _commit(), known)


def _commit() -> str | None:
    command = ["git", "-C", str(Path(stretch_bt.__file__).parent), *_DESCRIBE]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=False)  # noqa: S603
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None
