"""Reconstruction: the picture of the cloud that a run saved."""

from __future__ import annotations

import base64

from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.report.text import section

__all__ = ["panel"]

NOTE = "points of the surface that was felt, from above, from the front and from the right, coloured by their standard deviation"


def panel(record: RecordReader) -> str:
    """Return the panel of a run that saved a cloud; nothing where there is none."""
    path = record.folder / "cloud.png"
    if not path.exists():
        return ""
    data = base64.b64encode(path.read_bytes()).decode()
    return section("Cloud", f'<img alt="cloud" style="max-width:100%" src="data:image/png;base64,{data}">', NOTE)
