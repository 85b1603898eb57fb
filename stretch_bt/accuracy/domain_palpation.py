"""Palpation: the error of a balloon's stiffness against the robot's time, over protocols and step sizes."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.points import Kind, Point

__all__ = ["ABOUT", "KINDS", "points"]

ABOUT = """\
Balloons of water, pudding and seeds in the twin at hertz fidelity with all noise of the bench camera, seeds 0 and 1; the force model is
that of the twin's own hand, so none of its error is in these. With --quick the balloon of seeds alone, seed 0.
Errors are relative: stiffness that at the last press, against what the scene knows at that moment, stiffness at drop that at 1.5 mm,
against the object's own. Robot seconds are of the run's clock, from its begin to the last look, of a run that failed to its end. A
variant is how much is averaged. from zero presses at each stretch from zero depth in steps of that size. At the depth limit of
palpate_stiffness these balloons need no stretch, so its steps are compared within 12 mm. CPU time is that of the run, the twin included."""

KINDS = {"stiffness": Kind("%", 100.0), "stiffness_at_drop": Kind("%", 100.0)}


def points(quick: bool) -> Iterator[Point]:
    """Yield every point; with `quick` those of one balloon and few settings."""
    from stretch_bt.accuracy.palpation import settings

    yield from settings.points(quick)
