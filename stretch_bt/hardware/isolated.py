"""How a process of our own is begun, so that no module of the current folder takes the place of an installed one."""

from __future__ import annotations

import os
import sys
import sysconfig
from pathlib import Path

from stretch_bt.threads import ONE_THREAD

__all__ = ["environment", "interpreter", "trusted_path"]

#: folder from which this package is imported
_HOME = Path(__file__).resolve().parents[2]


def interpreter() -> list[str]:
    """Return the begin of a command line: this interpreter, which puts no folder of its own choice on its path."""
    return [sys.executable, "-P"]


def environment() -> dict[str, str]:
    """Return this process's environment for another one, which finds the same packages.

    The current folder is left out: whoever may write there could replace a client of a device, as `rtde_receive`.
    It stays where this package is imported from it. BLAS gets one thread: on matrices as small as ours a second
    one only waits, and takes a core for that.
    """
    return {**os.environ, **ONE_THREAD, "PYTHONSAFEPATH": "1", "PYTHONPATH": os.pathsep.join(trusted_path())}


def _here() -> Path | None:
    try:
        return Path.cwd().resolve()
    except FileNotFoundError:  # somebody removed it: nothing can be imported from it
        return None


def trusted_path() -> list[str]:
    """Return the path of this interpreter as absolute paths, without the current folder.

    A current folder into which packages are installed, or from which this one is imported, stays.
    """
    here = _here()
    kept = {_HOME, *(Path(folder).resolve() for folder in sysconfig.get_paths().values())}
    found = [Path(entry).resolve() for entry in sys.path if entry and (here or Path(entry).is_absolute())]
    return list(dict.fromkeys(str(path) for path in found if path != here or path in kept))
