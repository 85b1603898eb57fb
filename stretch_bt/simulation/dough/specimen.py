"""A lump of dough in a run: how it gives way under the hand, and how rolling and pressing change it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.dough.disc import cracked, edge_roughness, hull, outline, silhouette
from stretch_bt.simulation.dough.lump import Lump, cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.resistance import Resistance
from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.objects.base import Moved, Specimen, Standing
from stretch_bt.simulation.objects.response import Law

if TYPE_CHECKING:
    from stretch_bt.simulation.hanging import Grip
    from stretch_bt.simulation.membrane.indenters.base import Indenter
    from stretch_bt.simulation.objects.dough import DoughObject

__all__ = ["DoughSpecimen", "DoughState"]

_KEPT = 16
_SHORTEST = 1e-3  # s; a step that takes no time has the rate of one this long
_LONGEST = 0.1  # s of a step: at 100 mm/s a tenth of the way round
_STIFF = 100.0  # factor on the modulus of a dough that does not spring back: its force still begins at 0
_BARELY = 1e-9  # m of plastic press that leave the shape as it is
_DISC = 0.2  # logarithm of the height lost from which on its top is flat
_PART = 0.25  # plastic strain rate over the rate at which a lump turns: a strain of 0.1 over 0.4 rad


@dataclass(frozen=True, slots=True)
class DoughState:
    """The lump, as it was when it rolled last, and the seed of its chances; `fresh` until it was first rolled or pressed for good.

    `raised` is how far it hangs above the table, m, while it sticks to the hand, None while it does not.
    """

    lump: Lump
    rolled: Lump
    seed: int = 0
    fresh: bool = True
    raised: float | None = None

    @property
    def pressed(self) -> float:
        """Logarithm of the height lost since it rolled."""
        return math.log(self.rolled.height / self.lump.height)


class DoughSpecimen(Specimen):
    """A lump that is pressed flat where it stands and rolls where the hand goes across.

    The drop counts from where its top stands now, under its own weight. Without plasticity it is rigid and rolls as it
    is; without springback it does not come back. How a path is cut into pieces does not matter while it rolls, and the
    path alone does, not time, unless its yield stress depends on the rate.
    """

    spec: DoughObject

    def __init__(self, spec: DoughObject, effects: Active) -> None:
        super().__init__(spec, None)
        self.dough = self._dough(spec, effects) if "plasticity" in effects else None
        self.spin = _number(effects, "spin_noise", "sd", 0.0)
        self.tack = _number(effects, "tack", "pull", 0.0)
        self.hold = _number(effects, "tack", "hold", 0.0)
        self.cracks = effects.get("edge_cracks")
        self._top = lru_cache(maxsize=_KEPT)(self._find_top)
        self._felt = lru_cache(maxsize=_KEPT)(self._make_felt)
        self._body = lru_cache(maxsize=_KEPT)(self._make_body)
        self._discs: dict[Lump, Indenter] = {}

    @property
    def memory(self) -> float:
        """A step of time, s, in which the hand goes a small part of the way round the lump."""
        return _LONGEST

    @property
    def timeless(self) -> bool:
        """Whether the path alone matters: not where its force depends on the rate."""
        return self.dough is None or self.dough.thickening == 0

    def start(self, seed: int = 0) -> DoughState:
        """Return the cube as it was cut, and the seed of its chances."""
        lump = cube(self.spec.edge, self.spec.directions, self.spec.heading)
        return DoughState(lump, lump, seed)

    def law(self, state: DoughState, dt: float) -> Law | None:
        """Return the force on its top, N, less its weight, by how far it is pressed down in a step of `dt`, s."""
        if self.dough is None:
            return None
        felt, step = self._felt(state.lump), max(dt, _SHORTEST)
        return lambda drop: self._pulled(*felt.force(drop, step))

    def standing(self, state: DoughState, drop: float) -> Standing:
        """Return its upper side where it rolled to, or the cube as it was cut."""
        spec, lump = self.spec, state.lump
        top = self._top(lump)
        if drop >= top - spec.base:
            raise NoEquilibrium(f"a drop of {drop * 1e3:.3g} mm would press the dough flat")
        body = spec.body() if state.fresh else self._disc(state) if state.pressed > _DISC else self._body(lump)
        x, y = spec.position.x + lump.x, spec.position.y + lump.y
        return Standing(
            body, x, y, spec.heading if state.fresh else 0.0, top - drop, _ball(lump), passing=not state.fresh
        )

    def after(self, state: DoughState, moved: Moved) -> DoughState:
        """Return the lump rolled where the hand went across while it pressed, else pressed as far as it gave way for good; or carried."""
        if state.raised:  # it hung, and did not roll
            state, moved = _carried(state, moved), replace(moved, across=(0.0, 0.0))
        shaped = self._shaped(state, moved)
        return shaped if self.tack <= 0 else replace(shaped, raised=_raised(moved))

    def grip(self, state: DoughState) -> Grip | None:
        """Return how it sticks to a hand that touched it: by a spot as wide as the radius of its ball."""
        if self.tack <= 0 or state.raised is None:
            return None
        from stretch_bt.simulation.hanging import Grip
        from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

        return Grip(self.tack, self.spec.weight, self.hold, Cylinder(round(state.lump.ball, 4)), state.raised)

    def _shaped(self, state: DoughState, moved: Moved) -> DoughState:
        push = -moved.force[2]
        if push <= 0.0:
            return state
        if moved.across != (0.0, 0.0):
            return self._rolled(state, moved, push)
        if self.dough is None or moved.drop <= 0:
            return state
        lump = state.lump
        plastic = self._felt(lump).plastic(moved.drop, max(moved.dt, _SHORTEST))
        if plastic < _BARELY:
            return state
        return replace(state, lump=lump.flattened(plastic), fresh=False)

    def known(self, state: DoughState, drop: float) -> dict[str, float]:
        """Return the radius, m, of the ball of its volume, its roundness now and when it rolled last, its thickness, m, and how
        round the outline is that it has as a disc, by each method, with the roughness of its edge, and its yield stress, Pa.
        """
        from stretch_bt.perception import circularity

        lump = state.lump
        height = lump.height - min(drop + self._sunk(lump), 0.9 * lump.height)
        line = self.outline(state, height)
        known = super().known(state, drop)
        if self.dough is None:
            del known["yield_stress"]
        contour, chain, low = (float(circularity(line, method=m)) for m in ("contour", "pixel_chain", "low_pass"))
        return {
            **known,
            "radius": lump.ball,
            "roundness": lump.roundness,
            "radius_spread": state.rolled.roundness,
            "thickness": height,
            **dict.fromkeys(("circularity", "circularity_true", "circularity_sensed"), contour),
            **dict.fromkeys(("pixel_chain", "pixel_chain_true"), chain),
            "low_pass_true": low,
            "edge_roughness": edge_roughness(line),
        }

    def sketch(self, state: DoughState) -> dict[str, list[tuple[float, float]]]:
        """Return its side view, above its underside, and the outline that it has or would be pressed to."""
        line = self.outline(state, state.lump.height if state.pressed > _DISC else state.lump.ball)
        if state.pressed > _DISC:
            side = silhouette(line, state.lump.height)
        else:
            points = state.lump.radii[:, None] * (state.lump.directions.vectors @ state.lump.rotation.T)
            side = hull(points[:, [0, 2]] + [0.0, state.lump.extent[0]])
        side = np.add(side, [0.0, state.raised or 0.0])
        return {name: [(float(x), float(y)) for x, y in closed] for name, closed in (("side", side), ("outline", line))}

    def outline(self, state: DoughState, height: float) -> npt.NDArray[np.float64]:
        """Return the outline (n, 2), m, about its middle, of the lump that rolled last, pressed to a height, m, with the cracks of its edge."""
        found = outline(state.rolled, height)
        if self.cracks is None:
            return found
        parameters: Any = self.cracks.parameters
        part = parameters.roughness * min(state.pressed, 1.0)
        return cracked(found, part, parameters.correlation, state.seed)

    def _rolled(self, state: DoughState, moved: Moved, push: float) -> DoughState:
        turned = math.hypot(*moved.across) / (2 * state.lump.ball)
        lump, _ = state.lump.rolled(
            moved.across,
            push,
            self.dough,
            weight=self.spec.weight,
            spin=self.spin,
            seed=state.seed,
            rate=_PART * turned / max(moved.dt, _SHORTEST) if not self.timeless else 0.0,
        )
        if lump.steps == state.lump.steps:  # not yet a step of rolling
            return replace(state, lump=lump)
        return replace(state, lump=lump, rolled=lump, fresh=False)

    def _disc(self, state: DoughState) -> Indenter:
        known = self._discs.get(state.lump)
        if known is None:
            from stretch_bt.simulation.dough.surface import disc_side

            line = self.outline(state, state.lump.height) * [1.0, -1.0]  # y against the world's
            known = disc_side(line, state.lump.height, state.lump.ball)
            self._discs.clear()
            self._discs[state.lump] = known
        return known

    def _pulled(self, force: float, slope: float) -> tuple[float, float]:
        """Return a force, N, and its slope less the pull of the tack, which grows with the first contact."""
        if self.tack <= 0:
            return force, slope
        away = math.exp(-force / self.tack)
        return force - self.tack * (1 - away), slope * (1 - away)

    def _find_top(self, lump: Lump) -> float:
        return self.spec.base + lump.height - self._sunk(lump)

    def _sunk(self, lump: Lump) -> float:
        """Return how far its top sinks under its own weight, m."""
        return 0.0 if self.dough is None else self._felt(lump).sunk

    def _make_felt(self, lump: Lump) -> Resistance:
        assert self.dough is not None
        return Resistance(lump, self.dough, self.spec.weight)

    def _make_body(self, lump: Lump) -> Indenter:
        from stretch_bt.simulation.dough.surface import upper_side

        return upper_side(lump)

    @staticmethod
    def _dough(spec: DoughObject, effects: Active) -> Dough:
        return Dough(
            spec.yield_stress,
            spec.modulus * (1.0 if "springback" in effects else _STIFF),
            _number(effects, "dough_viscosity", "thickening", 0.0),
            _number(effects, "dough_viscosity", "power", 1.0),
            tension=spec.smoothing,
        )


def _raised(moved: Moved) -> float | None:
    """Return how far dough hangs above the table, m: not while it is pressed, None where the hand does not touch it."""
    return 0.0 if moved.force[2] < 0 else moved.raised


def _carried(state: DoughState, moved: Moved) -> DoughState:
    """Return dough that hung where the hand took it, which may have set it down; dough that tore itself loose is left where it was."""
    if _raised(moved) is None:
        return state
    x, y = moved.across
    return replace(state, lump=replace(state.lump, x=state.lump.x + x, y=state.lump.y + y))


def _ball(lump: Lump) -> Indenter:
    """Return a ball of about the volume, whose force on the sheet is within 8 % of the lump's; radii in steps of a hundredth."""
    from stretch_bt.simulation.membrane.indenters.sphere import Sphere

    return Sphere(2 * round(lump.ball, 4))


def _number(effects: Active, effect: str, name: str, off: float) -> float:
    """Return a parameter of an effect, or the value that stands for its being off."""
    found = effects.get(effect)
    return off if found is None else float(getattr(found.parameters, name))
