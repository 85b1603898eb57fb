"""The force model that a run used, read again by the name that its param `model` had."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from stretch_bt.errors import InvalidInput
from stretch_bt.model.force.force_model import FITTED, FITTED_FILE, SHIPPED, ForceModel, shipped
from stretch_bt.runtime.record import RecordReader

__all__ = ["used_model"]

_SECOND = 1.0  # s, to which a record says when it was begun


def used_model(record: RecordReader) -> tuple[ForceModel | None, str]:
    """Return the model and a remark on it; None and the reason where it cannot be had."""
    given, params = record.run_info.get("set") or {}, record.header.get("params") or {}
    name = given.get("model", params.get("model"))
    if not isinstance(name, str):
        return None, "without the curves of the force model: the tree has no param 'model' that names it"
    if name in SHIPPED:
        return shipped(name), f"curves: shipped force model '{name}'"
    if name == FITTED:
        return _loaded(record.folder / FITTED_FILE, "curves: the force model that this run fitted")
    changed = _changed(record, Path(name))
    return _loaded(
        name, f"curves: {Path(name).name}" + (", which was written again after the run began" if changed else "")
    )


def _loaded(file: str | Path, told: str) -> tuple[ForceModel | None, str]:
    try:
        return ForceModel.load(file), told
    except InvalidInput as error:
        return None, f"without the curves of the force model: {error}"


def _changed(record: RecordReader, path: Path) -> bool:
    """Return whether the file is newer than the beginning of the run, as far as both are known."""
    try:
        began = datetime.fromisoformat(str(record.run_info.get("started")))
        return path.stat().st_mtime > began.timestamp() + _SECOND
    except (ValueError, OSError):
        return False
