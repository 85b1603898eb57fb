"""Parts of the report that only some tasks have: a module each, whose `panel(record)` returns HTML, or nothing."""

from __future__ import annotations

from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.report.panels import cloud, cookie, palpation, sensitivity, shape

__all__ = ["panels"]

PANELS = (palpation, sensitivity, shape, cloud, cookie)


def panels(record: RecordReader) -> str:
    """Return all that the record has what they need for."""
    return "".join(module.panel(record) for module in PANELS)
