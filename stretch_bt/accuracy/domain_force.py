"""Force models: error against CPU time of a prediction, on a hand that they know from a characterisation with noise."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import CPU_MS, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind, Setting

__all__ = ["DOMAIN"]

ABOUT = """\
A hand with weight and bending, without friction and softening, on a mesh finer than the mesh of the model's table; forces of hemispheres
by the protocol for tasks, with the noise of sensor, arm and mount. Errors are at diameters, stretches and depths between the
measured ones, against the hand's own forces, as a part of them: root mean squares over depths of 2.5 to 13.5 mm. `hertz` has one
modulus for all, `calibrated` is the paper's law, `membrane` the table, `sheet` the solve of the sheet from its last press. The
reference's own error is 2.5 times its change from elements 1.4 times as long. With `--quick` fewer presses are measured, on coarser elements."""

KINDS = {"force": Kind("%", 100.0)}
OMITTED = {
    "hands that no model knows": "those with friction and softening take an hour each; [figures](../figures.md#force-models) has 19",
    "cylinders and cones": "the membrane model is for spheres alone",
}


def take(found: DomainSummaries) -> str:
    """Say which model to take."""
    least = found.setting(Setting("calibrated", "the paper's law"), "force", CPU_MS)
    return (
        f"So take the default of the palpation trees, {found.default('force', CPU_MS)}; the paper's law, {least}, is as cheap. "
        f"The sheet itself is worth its time only for hands that the table does not cover: other lengths, thicknesses or mounts."
    )


def warm() -> None:
    """Press a sphere as the hand does, and load the table."""
    from stretch_bt.accuracy.force import ladder

    ladder.warm()


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every model at every diameter and stretch; with `quick` at one stretch alone."""
    from stretch_bt.accuracy.force import ladder

    yield from ladder.jobs(quick)


DOMAIN = Domain(ABOUT, KINDS, (Panel("force", CPU_MS),), take, OMITTED, warm, jobs)
