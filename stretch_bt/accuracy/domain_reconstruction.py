"""Reconstruction: error of the surface and the part of it that is missed, by presses."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import PRESSES, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind, Setting

__all__ = ["DOMAIN"]

ABOUT = """\
Six shipped objects under `reconstruct` in the twin, `bench` camera, effects as the advisor chooses them, seed 0. `planned` goes where most is
expected that was not felt yet, up to so many presses; `square grid` presses over the object's outline. The surface's error is the distance of
the cloud's points from the true surface, which is exact, root mean square over cells of 1 mm where the object has upper surface; `missed` is
the part of that surface, normals within 45 degrees of the vertical, without a point in its cell."""

KINDS = {"surface": Kind("mm", 1e3, "m"), "missed": Kind("%", 100.0), "cloud": Kind("mm", 1e3, "m")}
OMITTED = {
    "points beyond the object's edges": "they err by ten times as much, as the membrane hangs free there; the rows have them as `cloud`",
    "dimensions": "their errors are stated with deviations; [figures](../figures.md#reconstruction) has 20 seeds",
    "wires, random bodies": "up to a minute a run; `python -m benchmarks.reconstruct` has them",
    "robot seconds and CPU time": "they go as the presses; the rows have them",
}


def take(found: DomainSummaries) -> str:
    """Say how many presses to take."""
    four = found.setting(Setting("square grid", "4"), "missed", PRESSES)
    one = found.setting(Setting("planned", "at most 1"), "missed", PRESSES)
    return (
        f"So take the default, {found.default('surface', PRESSES)}. More presses do not make the surface truer but miss less of large and round "
        f"objects: {found.default('missed', PRESSES)}, with one press {one}, with a grid of four {four}."
    )


def warm() -> None:
    """Load the compiled code, and press once, as the code of the sheet is compiled at its first press."""
    from stretch_bt.accuracy.kernels import load_kernels
    from stretch_bt.accuracy.twin.outcome import outcome, with_effects

    load_kernels("perception", "simulation.camera", "simulation.membrane")
    outcome(with_effects("calibration_sphere", {"bending": "on"}), 0)


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every object by every way."""
    from stretch_bt.accuracy.reconstruction import presses

    yield from presses.jobs()


PANELS = (
    Panel("surface", PRESSES, (), "error of the upper surface"),
    Panel("missed", PRESSES, (), "upper surface that is missed"),
)
DOMAIN = Domain(ABOUT, KINDS, PANELS, take, OMITTED, warm, jobs)
