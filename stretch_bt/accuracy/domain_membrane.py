"""The membrane solvers: force, surface and contact radius against CPU time, from flat and from the last press, and other simulators."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy import peers
from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import CPU_MS, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind

__all__ = ["DOMAIN"]

ABOUT = """\
Presses of 3, 8 and 15 mm, at stretch 0 to 80 mm, by spheres, a cylinder, a cone, a cube, a wire and two spheres. `from the last press` is
the last step of 1 mm after two others. Errors are against the sheet on graded elements of 0.5 mm (0.3 mm under the wire, 0.2 mm under the
cone) that grow by 1.2, solved to the last digit. The reference's own error is stated as 2.5 times its change from elements 1.4 times as
long, right for first order and too much for any higher. `coarsen` is the length of the elements over the usual one; `within(x)` stops
when steps change the force by less than x, and `settled` series use it. hertz and axisymmetric take a round membrane in place of the
rectangular one: their error on a press is the model's."""

KINDS = {"force": Kind("%", 100.0), "surface": Kind("um", 1e6, "m"), "contact_radius": Kind("%", 100.0)}
FLAT, LAST = "sheet from flat", "sheet from the last press"
PEERS = peers.names(peers.PRESSES)
ONE = ("hertz", "axisymmetric", FLAT, f"{FLAT}, settled", *sorted(PEERS))
LOOP = (LAST, f"{LAST}, settled")
OMITTED = {
    "surface and contact radius": "they rank the settings as the force does; the rows have them",
    "uniform elements": "at the same error they cost several times as much as graded ones; the rows have them",
    "the axisymmetric solver on its own round membrane": "it is within 1e-7 of known forces, so that its error here is the model's",
    "friction, softening and weight": "the part twin shows what they change",
}


def take(found: DomainSummaries) -> str:
    """Say which setting to take."""
    default, half = found.default("force", CPU_MS), found.cheapest("force", CPU_MS, 0.005, (FLAT, f"{FLAT}, settled"))
    one, two = (found.cheapest("force", CPU_MS, within, LOOP) for within in (0.01, 0.005))
    same = ", of those from flat also the cheapest within 0.5 %" if half == default else f"; for 0.5 % take {half}"
    return (
        f"So take the default of `press` for one press, {default}{same}; in a loop, where each press begins at the last, "
        f"take {one} for 1 % and {two} for 0.5 %."
    )


def warm() -> None:
    """Press each kind of indenter once by each solver."""
    from stretch_bt.accuracy.membrane import presses

    presses.compile_kernels()


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every press by every solver; with `quick` three presses come first, and the others last for ever."""
    from stretch_bt.accuracy.membrane import known, presses

    yield from presses.jobs(quick)
    yield from known.jobs()
    yield from peers.presses()


PANELS = (
    Panel("force", CPU_MS, ONE, "one press: error of the force"),
    Panel("force", CPU_MS, LOOP, "in a loop, from the last press: error of the force"),
)
DOMAIN = Domain(ABOUT, KINDS, PANELS, take, OMITTED, warm, jobs, PEERS)
