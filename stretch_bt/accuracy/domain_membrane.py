"""The membrane solvers: force, surface and contact radius against CPU time, cold and warm, and other simulators."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.points import Kind, Point

__all__ = ["ABOUT", "KINDS", "points"]

ABOUT = """\
Presses of 3, 8 and 15 mm; a warm step is the last of 1 mm after two others. Error against the sheet on graded elements of
0.5 mm (0.3 mm under the wire, 0.2 mm under the cone) that grow by 1.2, exact. The reference's own error is stated as 2.5
times its change from elements 1.4 times as long, right for first order and too much for any higher; for one press that
change can be small by chance, so read its line as a whole.
hertz and axisymmetric stand a round membrane in for the rectangular one: their error on a press is the model's."""

KINDS = {"force": Kind("%", 100.0), "surface": Kind("um", 1e6), "contact_radius": Kind("%", 100.0)}


def points(quick: bool) -> Iterator[Point]:
    """Yield every point; with `quick` those of three presses."""
    from stretch_bt.accuracy import peers
    from stretch_bt.accuracy.membrane import known, presses

    presses.compile_kernels()
    yield from known.axisymmetric(quick)
    yield from known.sheet(quick)
    yield from presses.points(quick)
    yield from peers.points()
