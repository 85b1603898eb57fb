"""The membrane at `sheet` fidelity: the finite-strain sheet, under any body anywhere."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from stretch_bt.errors import Impossible, NoEquilibrium
from stretch_bt.simulation.camera.skin import Grid, Skin
from stretch_bt.simulation.effects.base import MembraneEffect
from stretch_bt.simulation.fidelity.base import Array, Place, Pressed
from stretch_bt.simulation.fidelity.between import Between
from stretch_bt.simulation.fidelity.curve import Curve
from stretch_bt.simulation.membrane.indenters.sphere import Sphere, goes_on_as
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.objects.response import Law
from stretch_bt.simulation.stats import Stats

if TYPE_CHECKING:  # numba comes along with it
    from stretch_bt.simulation.membrane.sheet.result import Load, Shape, SheetPress

__all__ = ["SheetFidelity"]

PITCH = 0.7e-3  # m of the unstretched sheet between points of its shape
_FELT, _KNOWN = 1e-5, 1e-10  # of a force that is solved each time, and of one on a smooth curve
_LOOSE = Settings.within(0.01)
_KEPT = 24  # places whose presses are kept
_LEAST = 1e-7  # m between presses that a slope is taken from
_RISE = 1.5  # power of depth that a force about grows with
_GRAZE = 2e-5  # m of travel; a touch that is lighter has no mesh fine enough, and the shape of this one
_LIGHT = 2e-4  # m of travel up to which a press that cannot be solved has the shape of one twice as deep


class SheetFidelity:
    """The sheet solver with the membrane effects that are on."""

    def __init__(
        self,
        width: float,
        gauge: float,
        thickness: float,
        shear_modulus: float,
        mount_prestretch: float,
        effects: Iterable[MembraneEffect] = (),
        settings: Settings | None = None,
        stats: Stats | None = None,
    ) -> None:
        self.stats = stats or Stats()
        on = Effects()
        for effect in effects:
            on = effect.on_sheet(on)
        self.sheet = Sheet(gauge, width, thickness, NeoHookean(shear_modulus), mount_prestretch, on)
        self.settings = settings or Settings()  # exact, so that a force does not depend on what was solved before
        self.remembers = on.mullins is not None or on.friction > 0
        self.close = _FELT if self.remembers else _KNOWN
        self._curves: OrderedDict[Place, Curve] = OrderedDict()
        self._last: OrderedDict[Place, tuple[Any, SheetPress]] = OrderedDict()
        self.resting = lru_cache(maxsize=_KEPT)(self._resting)
        self._hang = lru_cache(maxsize=_KEPT)(self._hang_at)

    def law(self, place: Place, state: Any) -> Law:
        """Return the force between solved depths, or of a solve at each depth where the membrane remembers."""
        if self.remembers:
            return self._felt(place, state)
        return self._curve(place)

    def press(self, place: Place, depth: float, state: Any) -> Pressed:
        """Return the solved shape."""
        solved = self._solve(place, depth, state)
        return Pressed(_grid(solved.shape), solved if self.remembers else None)

    def force(self, place: Place, depth: float, state: Any) -> Array:
        """Return the force, off centre or tilted with a part across."""
        return self._solved_force(place, depth, state) if self.remembers else self._curve(place).force(depth)

    def released(self, state: Any) -> Any:
        """Return the softening alone; without contact nothing slides on, so that friction begins anew."""
        return state.let_go() if state is not None and self.sheet.effects.mullins is not None else None

    def lift(self, stretch: float) -> float:
        """Return how far the membrane hangs, m."""
        return self._hang(stretch) if self.sheet.effects.sag else 0.0

    def _hang_at(self, stretch: float) -> float:
        return max(0.0, -float(self.resting(stretch).points(3, 3)[1, 1, 2]))

    def free(self, stretch: float) -> Skin:
        """Return the membrane as it hangs, flat when it has no weight, narrower in its middle when stretched."""
        return _grid(self.resting(stretch))

    def _resting(self, stretch: float) -> Shape:
        from stretch_bt.simulation.membrane.sheet.hanging import hang

        return hang(self.sheet, stretch)

    def _felt(self, place: Place, state: Any) -> Law:
        """Return a law that solves at each depth; its slope is that of a power law first, then that between solves."""
        solved: list[tuple[float, float]] = []

        def law(depth: float) -> tuple[float, float]:
            travel = depth + self.lift(place.stretch)
            if travel <= 0:
                return 0.0, 0.0
            force = float(self._solved_force(place, depth, state)[2])
            nearest = min(solved, key=lambda s: abs(s[0] - travel), default=(travel, force))
            solved.append((travel, force))
            if abs(nearest[0] - travel) < _LEAST:
                return force, _RISE * force / travel
            return force, (force - nearest[1]) / (travel - nearest[0])

        return law

    def _solved_force(self, place: Place, depth: float, state: Any) -> Array:
        """Return the force (3,), N, of a solve; where it is too light for one, its part of that of the shallowest press that is."""
        solved = self._solve(place, depth, state)
        share: float = min((depth + self.lift(place.stretch)) / solved.load.travel, 1.0) ** _RISE
        return np.asarray(solved.force * share)

    def _curve(self, place: Place) -> Curve | Between:
        """Return the force of a body; of a ball whose radius varies, that between balls of fixed radii."""
        if place.varies and isinstance(place.body, Sphere):
            return Between(place.body, lambda ball: self._fixed(replace(place, body=ball, varies=False)))
        return self._fixed(place)

    def _fixed(self, place: Place) -> Curve:
        if place not in self._curves:
            made = Curve(lambda depth: self._solved_force(place, depth, None), self.lift(place.stretch))
            _keep(self._curves, place, made)
        return self._curves[place]

    def _solve(self, place: Place, depth: float, state: Any) -> SheetPress:
        """Solve from what the membrane remembers, else from the last press at the same place, else from flat."""
        load = self._load(place, depth)
        known = state if self.remembers else None
        before, last = self._last.get(place, (None, None))
        if last is not None and before is known and last.load == load:
            return last
        start = known if self.remembers else last
        if start is not None and not goes_on_as(start.load.indenter, load.indenter):
            start = start.let_go()  # friction remembers how one body slid
        with self.stats.timed("solve"):
            solved = self._balanced(load, start)
        _keep(self._last, place, (known, solved))
        return solved

    def _balanced(self, load: Load, start: SheetPress | None) -> SheetPress:
        """Return a press; a touch that is too light to be told from the rounding of energies gives way to a deeper one."""
        from stretch_bt.simulation.membrane.sheet.solver import solve

        try:
            return solve(self.sheet, load, self.settings, start)
        except Impossible:
            raise
        except NoEquilibrium as failure:
            with suppress(NoEquilibrium):  # looser where forces cannot balance exactly
                return solve(self.sheet, load, _LOOSE, start)
            if load.travel > _LIGHT:
                raise failure from None
        return self._balanced(replace(load, depth=load.depth + load.travel), start)

    def _load(self, place: Place, depth: float) -> Load:
        from stretch_bt.simulation.membrane.indenters.turned import turn
        from stretch_bt.simulation.membrane.sheet.result import Load

        if place.body is None:
            raise NoEquilibrium(
                "an object wider than the membrane meets the fingers; only hertz fidelity has an answer"
            )
        body, lift = turn(place.body, place.heading), self.lift(place.stretch)
        return Load(body, place.stretch, max(depth, _GRAZE - lift), place.at, place.tilt, lift)


def _keep(kept: OrderedDict[Any, Any], key: Any, value: Any) -> None:
    kept[key] = value
    kept.move_to_end(key)
    while len(kept) > _KEPT:
        kept.popitem(last=False)


def _grid(shape: Shape) -> Grid:
    """Return the shape on a grid that is even on the unstretched sheet."""
    columns, rows = (round((a.breaks[-1] - a.breaks[0]) * shape.unit / PITCH) + 1 for a in (shape.mesh.x, shape.mesh.y))
    return Grid(np.ascontiguousarray(shape.points(columns, rows)))
