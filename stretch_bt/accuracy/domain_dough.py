"""Rolling dough: error of its roundness against CPU time, over the directions in which the radius is known."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import CPU_MS, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind

__all__ = ["DOMAIN"]

ABOUT = """\
Cubes of 25 mm that lie at random, yield stress 5 kPa, modulus 10 to 30 times that, rolled for 2 m on a circle and on a figure-eight with
a spin noise of 0.1. The error is of the spread, the standard deviation of the radius over its mean (0.125 of a cube, 0 of a ball): how
far it is off the same body with 8000 directions, whose own error is its change from 4000. The rows also compare the median spread of 15
lumps with a separate program of the same model, whose medians are 0.024 to 0.098 and scatter by some 0.004."""

KINDS = {"spread": Kind("1", 1.0), "known_spread": Kind("1", 1.0)}
OMITTED = {
    "material points": "another model, 4 to 11 s a lump, 0.01 to 0.08 off: `python benchmarks/dough_mpm.py`, [figures](../figures.md#the-cookie)",
    "the separate program": "it is not shipped; the rows have the differences of its medians",
    "the press to a disc": "a law of its own without a resolution; its parameters are assumptions of the scene",
    "real dough": "nobody has measured a yield stress of such a dough",
}


def take(found: DomainSummaries) -> str:
    """Say how many directions to take."""
    return (
        f"So take the default, {found.default('spread', CPU_MS)}; material points, another model, differ from it by 0.01 to 0.08, "
        f"more than directions add. "
        f"For 0.002 take {found.cheapest('spread', CPU_MS, 0.002)}."
    )


def warm() -> None:
    """Roll a lump a little."""
    from stretch_bt.accuracy.dough import directions

    directions.warm()


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every lump with every count of directions."""
    from stretch_bt.accuracy.dough import directions

    yield from directions.jobs()


PANELS = (Panel("spread", CPU_MS, ("reduced body",), "error of the spread of the radius, after 2 m"),)
DOMAIN = Domain(ABOUT, KINDS, PANELS, take, OMITTED, warm, jobs)
