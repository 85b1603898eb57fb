"""From a scene to the model of its membrane."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from stretch_bt.simulation.effects.base import MembraneEffect
from stretch_bt.simulation.fidelity.base import Fidelity
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.stats import Stats

__all__ = ["Membrane", "make_fidelity"]


@dataclass(frozen=True, slots=True)
class Membrane:
    """Rest length between the fingers, width and thickness of the membrane, m."""

    gauge: float = 0.100
    width: float = 0.090
    thickness: float = 0.002


def make_fidelity(
    scene: Scene,
    membrane: Membrane,
    effects: Iterable[MembraneEffect],
    stats: Stats,
    settings: Settings | None = None,
) -> Fidelity:
    """Return the model that the scene's `fidelity` names; its solves are counted in `stats`. A sheet is solved with `settings`."""
    sizes = (membrane.width, membrane.gauge)
    made_of = (*sizes, membrane.thickness)
    match scene.fidelity:
        case "hertz":
            from stretch_bt.simulation.fidelity.hertz import HertzFidelity

            return HertzFidelity(*sizes)
        case "axisymmetric":
            from stretch_bt.simulation.fidelity.axisymmetric import AxisymmetricFidelity

            return AxisymmetricFidelity(*made_of, scene.hand.material(), scene.hand.mount_prestretch, stats=stats)
        case "sheet" | "auto":
            from stretch_bt.simulation.fidelity.sheet import SheetFidelity

            return SheetFidelity(
                *made_of, scene.hand.material(), scene.hand.mount_prestretch, effects, settings, stats=stats
            )
