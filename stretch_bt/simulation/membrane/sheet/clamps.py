"""Refuses a body where a clamp already is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stretch_bt.errors import Impossible
from stretch_bt.simulation.membrane.indenters.placed import Placed
from stretch_bt.simulation.membrane.sheet.geometry import Sheet

__all__ = ["OVERLAP", "check_clamps"]

OVERLAP = "the indenter overlaps a clamp, which does not give way: the sheet cannot leave it without passing through"
_TOUCH = 1e-6  # of the gauge; a body that touches a clamp does not overlap it


def check_clamps(sheet: Sheet, bodies: Sequence[Placed], span: float) -> None:
    """Raise Impossible where a clamped edge runs through a body, the clamps being `span` sheet units apart.

    The edges stay in the plane z = 0 whatever the sheet does, so no shape of it keeps out of such a body.
    """
    axes = np.array([body.origin[:2] for body in bodies]) / sheet.unit
    places = sheet.outline.clamps(sheet.width / sheet.unit, span, axes) * sheet.unit
    edges = np.column_stack([places, np.zeros(len(places))])
    if any(body.gap(edges).distance.min() < -_TOUCH * sheet.gauge for body in bodies):
        raise Impossible(OVERLAP)
