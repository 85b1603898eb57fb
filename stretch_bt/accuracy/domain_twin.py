"""The twin: error against CPU time, over which effects are on."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import CPU_S, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind, Setting

__all__ = ["DOMAIN"]

ABOUT = """\
The task of a shipped scene, one press, a roll or a palpation, with what the advisor switches on (`auto`), with every effect that the
scene can have, with none, and with the `least` that agrees with everything on in the mean, found by taking away one effect after the
other. A case is a run; its error is the difference from the run of the same seed with everything on, over the scene's tolerance:
the observable that differs most counts. Where a set of effects draws other noise than everything on does, that chance is in it, too.
Everything on is the twin itself, so that it has no error of its own here and stands at the lower edge. Friction and softening depend on
the whole path before, which costs five to ten times the CPU time. No run here asks for a tolerance: `auto` goes by the scene's own, up to
which the effects that are off may change a result, as estimates say that are right within a factor of about two. With `--tolerance` the
advisor counts a margin and the sheet's own error too, and of one press' force it kept 59 of 60 within what was asked for
([how](../twin.md#a-tolerance-for-a-run)); here heights, sizes and whole palpations count as well, the one that differs most."""

KINDS = {"apart": Kind("tolerances", 1.0)}
OMITTED = {
    "how far the twin is off a real hand": "no measurement of one is here",
    "the sheet's own error": "both runs have it; the part membrane shows it",
    "three balloons, three other objects": "minutes a run with everything on; [figures](../figures.md#twin) has them",
}


def take(found: DomainSummaries) -> str:
    """Say which effects to switch on."""
    everything = found.setting(Setting("effects", "everything"), "apart", CPU_S)
    default, within = found.default("apart", CPU_S), found.cheapest("apart", CPU_S, 1.0)
    below = f"whose bar ends above one tolerance; the cheapest whose bar ends below it is {within}"
    below = "which also is the cheapest within one tolerance" if within == default else below
    nothing = found.setting(Setting("effects", "nothing"), "apart", CPU_S)
    return (
        f"So take the default, {default}, {below}. Everything, {everything}, is for the question how much an effect changes. "
        f"Nothing is no way to save time, {nothing}: a sheet that does not bend takes up to twice the time to solve."
    )


def warm() -> None:
    """Load the compiled code, and run one press with an effect that no other has code of."""
    from stretch_bt.accuracy.kernels import load_kernels
    from stretch_bt.accuracy.twin.outcome import outcome, with_effects

    load_kernels("perception", "simulation.camera", "simulation.membrane")
    outcome(with_effects("calibration_sphere", {"friction": "on"}), 0)


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every scene with every set of effects; with `quick` one run against all effects that remember nothing comes first."""
    from stretch_bt.accuracy.twin import sets

    if quick:
        yield from sets.small_jobs()
    yield from sets.jobs()


PANELS = (Panel("apart", CPU_S, (), "difference to everything on"),)
DOMAIN = Domain(ABOUT, KINDS, PANELS, take, OMITTED, warm, jobs)
