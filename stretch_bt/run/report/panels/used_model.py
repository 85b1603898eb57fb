"""The force model that a run used, read again by the name that its param `model` had."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from stretch_bt.errors import InvalidInput
from stretch_bt.model.force.force_model import SHIPPED, ForceModel, shipped
from stretch_bt.run.record import RecordReader

__all__ = ["used_model"]

_SECOND = 1.0  # s, to which a record says when it was begun


def used_model(record: RecordReader) -> tuple[ForceModel | None, str]:
    """Return the model and what there is to say of it; None and the reason where it is not to be had."""
    given, params = record.run_info.get("set") or {}, record.header.get("params") or {}
    name = given.get("model", params.get("model"))
    if not isinstance(name, str):
        return None, "without the curves of the force model: the tree has no param 'model' that names it"
    if name in SHIPPED:
        return shipped(name), f"curves: shipped force model '{name}'"
    try:
        model = ForceModel.load(name)
    except InvalidInput as error:
        return None, f"without the curves of the force model: {error}"
    changed = _changed(record, Path(name))
    return model, f"curves: {Path(name).name}" + (", which was written again after the run began" if changed else "")


def _changed(record: RecordReader, path: Path) -> bool:
    """Return whether the file is newer than the beginning of the run, as far as both are known."""
    try:
        began = datetime.fromisoformat(str(record.run_info.get("started")))
        return path.stat().st_mtime > began.timestamp() + _SECOND
    except (ValueError, OSError):
        return False
