"""The record of what is called on an open cell: events and readings, without a tree that could be ticked again."""

from __future__ import annotations

import platform
import sys
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.hardware.cell_file import CellSpec
    from stretch_bt.runtime.record import RunRecord

__all__ = ["record_of_calls"]


def record_of_calls(out: Path, spec: CellSpec, *, scene: str | None, seed: int) -> RunRecord:
    """Begin the record of all calls in a folder, which must be empty or absent.

    Raises
    ------
    RecordError
        The folder holds something, or cannot be written.
    """
    from stretch_bt.runtime.prepare import VERSIONS, versions
    from stretch_bt.runtime.provenance import machine, places_of
    from stretch_bt.runtime.record import RunRecord

    record = RunRecord(out)
    name, cell = Path(scene).name if scene else None, spec.path.name
    header: dict[str, Any] = {"tree": None, "calls": True, "seed": seed, "scene": name, "cell": cell, "keys": {}}
    about = {
        "started": datetime.now().astimezone().isoformat(timespec="seconds"),
        "host": platform.node(),
        "command": sys.argv,
        "python": platform.python_version(),
        "versions": versions(*VERSIONS),
        "machine": machine(compiled=True),
    }
    versioned = {**header, "versions": versions("stretch-bt", "py_trees", "numpy")}
    record.start(versioned, {**header, **about}, places_of(spec))
    return record
