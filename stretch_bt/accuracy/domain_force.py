"""Force models: error against CPU time of a prediction, on a hand that they know from a characterisation with noise."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.points import Kind, Point

__all__ = ["ABOUT", "KINDS", "points"]

ABOUT = """\
A hand with weight and bending, without friction and softening, on a mesh finer than that of the model's table; forces of hemispheres
by the protocol for tasks, with the noise of sensor, arm and mount. Errors are at diameters, stretches and depths between those that
were measured, against the hand's own forces, as a part of them: root mean squares over depths. hertz has one modulus for all, calibrated is the
paper's law, membrane the table, sheet the solve of the sheet from its last press."""

KINDS = {"force": Kind("%", 100.0)}


def points(quick: bool) -> Iterator[Point]:
    """Yield every point; with `quick` those of one stretch."""
    from stretch_bt.accuracy.force import ladder

    yield from ladder.points(quick)
