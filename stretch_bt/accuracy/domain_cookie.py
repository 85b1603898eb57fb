"""The cookie: how far it is from a circle, by the minutes that its task takes."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import ROBOT_MIN, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind, Setting

__all__ = ["DOMAIN"]

ABOUT = """\
Twenty drawn cubes of dough, 20 to 30 mm, yield stress 2 to 10 kPa, in the twin with the noise of camera and arm, shaped by the paper's tree
`form_cookie` and by `form_cookie_fast`, as shipped and with stop rules that end sooner or later. The error is 1 less
the circularity of the true outline, 4 pi area over perimeter squared; the scene knows it. Minutes are the time of the task. A
lump that is given up has no answer."""

KINDS = {"circularity": Kind("1", 1.0), "sensed": Kind("1", 1.0)}
OMITTED = {
    "the sensed circularity": "it is off the true one by some 0.01, which it states; the rows have it",
    "other paths of rolling": "tried on the body alone; [figures](../figures.md#the-cookie)",
    "material points in place of the reduced body": "they rank the trees alike, and ask for lighter forces; `python benchmarks/dough_mpm.py`",
    "a stricter rule of the paper's tree": "within 0.5 mm in place of 1 mm, ten heights of the lump of seed 0 never came in two minutes",
    "CPU time": "it goes as the minutes; the rows have it",
}


def take(found: DomainSummaries) -> str:
    """Say which tree to take."""
    fast = found.setting(Setting("form_cookie_fast", "as shipped"), "circularity", ROBOT_MIN)
    return (
        f"So take {fast} in place of the paper's tree, {found.default('circularity', ROBOT_MIN)}, "
        "whose rule stops too soon on stiff lumps. A square would lack 0.21."
    )


def warm() -> None:
    """Load the compiled code."""
    from stretch_bt.accuracy.kernels import load_kernels

    load_kernels("perception", "simulation.camera", "simulation.membrane", "simulation.dough")


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every lump by every tree and rule."""
    from stretch_bt.accuracy.cookie import cookies

    yield from cookies.jobs()


PANELS = (Panel("circularity", ROBOT_MIN, (), "1 less the circularity"),)
DOMAIN = Domain(ABOUT, KINDS, PANELS, take, OMITTED, warm, jobs)
