"""Palpation: the error of a balloon's stiffness against the robot's time, over protocols and step sizes."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import ROBOT_S, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind, Setting

__all__ = ["DOMAIN"]

ABOUT = """\
Balloons of water, pudding and seeds in the twin at hertz fidelity with all noise of the bench camera, seeds 0 to 3; the force model is
the twin's own hand, so none of its error is in these. Errors are relative, of the stiffness at the last press, against the
scene's own stiffness at that moment, which is exact. Robot seconds are of the run's clock, from its begin to the last look; of a run
that failed, to its end. A variant is how much is averaged. `from zero` presses at each stretch from zero depth in steps of that size."""

KINDS = {"stiffness": Kind("%", 100.0), "stiffness_at_drop": Kind("%", 100.0)}
DRAWN = ("palpate_stiffness", "palpate_active", "from zero by 0.5 mm", "from zero by 1 mm", "from zero by 2 mm")
OMITTED = {
    "the stiffness at a drop of 1.5 mm": "it errs two to four times as much, as the height at no force is an extrapolation; the rows have it",
    "stretch steps of 5, 10 and 20 mm": "these balloons need none; within 12 mm of depth they do, and the rows have that",
    "the sheet in place of hertz": "its runs take ten times the CPU time and its errors come from the same estimator",
    "the error of the hand's calibration": "5 to 7 % of a force with the shipped model; [force](../force.md) says how it is measured",
}


def take(found: DomainSummaries) -> str:
    """Say which protocol to take."""
    active = found.setting(Setting("palpate_active", "as shipped"), "stiffness", ROBOT_S)
    return (
        f"So take {found.default('stiffness', ROBOT_S)}, or palpate_active, which chooses its presses by their stated error, {active}: "
        f"these runs do not distinguish the two. The least time in which every run is within 10 % is {found.cheapest('stiffness', ROBOT_S, 0.10)}."
    )


def warm() -> None:
    """Load the compiled code of perception and of the twin at hertz fidelity."""
    from stretch_bt.accuracy.kernels import load_kernels

    load_kernels("perception", "simulation.camera")


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every run; with `quick` one seed comes first."""
    from stretch_bt.accuracy.palpation import settings

    yield from settings.jobs()


DOMAIN = Domain(ABOUT, KINDS, (Panel("stiffness", ROBOT_S, DRAWN),), take, OMITTED, warm, jobs)
