"""From an earlier press to the first guess of the next one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stretch_bt.simulation.membrane.sheet.layout import Layout
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.result import Memory, SheetPress
from stretch_bt.simulation.membrane.sheet.spline import Array
from stretch_bt.simulation.membrane.sheet.start import carried

__all__ = ["predict"]


def predict(layout: Layout, start: SheetPress) -> tuple[Mesh, Array, tuple[float, ...], Memory]:
    """Return mesh, control points (ny, nx, 3) and offsets to begin with, and the press' memory of `start`."""
    change, old = layout.load.moves() - start.load.moves(), start.shape.control
    if layout.fits(start):
        mesh, memory, drift = start.shape.mesh, start.memory, layout.drift(start)
    else:
        mesh, drift = layout.mesh(), 0.0
        old = carried(start.shape.mesh, old, mesh)
        memory = replace(start.memory, previous=None, offsets=_rescaled(layout, start))
    control, offsets = _ahead(layout, start, memory, old, change)
    clamped = layout.sheet.outline.clamped(mesh, control, layout.span)
    return mesh, clamped, offsets, Memory((), old, memory.offsets, change, drift)


def _ahead(
    layout: Layout, start: SheetPress, memory: Memory, old: Array, change: Array
) -> tuple[Array, tuple[float, ...]]:
    """Return control points and offsets on the straight line through the last two presses, else scaled ones."""
    ratio = _ratio(change, memory.change)
    if ratio is not None and memory.previous is not None and memory.previous_offsets is not None:
        pairs = zip(memory.offsets, memory.previous_offsets, strict=True)
        return old + ratio * (old - memory.previous), tuple(max(o + ratio * (o - p), 0.0) for o, p in pairs)
    scaled = old.copy()
    scaled[..., 1] *= layout.span / layout.sheet.span(start.load.stretch)
    deeper = layout.load.travel / start.load.travel
    scaled[..., 2] = deeper * (scaled[..., 2] + start.load.hang / layout.unit) - layout.load.hang / layout.unit
    return scaled, memory.offsets


def _rescaled(layout: Layout, start: SheetPress) -> tuple[float, ...]:
    """Return the offsets of an earlier press for the stiffness of the contacts on a new mesh."""
    pressures = [o * c.stiffness for o, c in zip(start.memory.offsets, start.contacts, strict=True)]
    if len(pressures) != len(layout.bodies):
        return tuple(0.0 for _ in layout.bodies)
    return tuple(p / k for p, k in zip(pressures, layout.stiffnesses(), strict=True))


def _ratio(change: Array, before: Array | None) -> float | None:
    """Return how many times the last change this one is, None where it leads elsewhere or too far."""
    if before is None or not np.any(before):
        return None
    ratio = float(change @ before / (before @ before))
    straight = np.abs(change - ratio * before).max() <= 1e-6 * np.abs(before).max()
    return ratio if straight and abs(ratio) <= 2 else None
