"""The membrane at `sheet` fidelity: the finite-strain sheet, under any body anywhere."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, replace
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
from stretch_bt.simulation.membrane.indenters.turned import turn
from stretch_bt.simulation.membrane.materials import Material
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.objects.response import Law
from stretch_bt.simulation.stats import Stats

if TYPE_CHECKING:  # numba comes along with it
    from scipy.interpolate import RegularGridInterpolator

    from stretch_bt.simulation.membrane.sheet.result import Load, Shape, SheetPress

__all__ = ["SheetFidelity"]

PITCH = 0.7e-3  # m of the unstretched sheet between points of its shape
_FELT, _KNOWN = 1e-5, 1e-10  # relative accuracy of a force that is solved each time, and of one on a smooth curve
_LOOSE = Settings.within(0.01)
_TOUCH = 3e-4  # m of travel up to which rounding is in the way of an exact balance
_PASSING = Settings.within(
    0.03
)  # its shape passes through edges by up to 0.9 mm, before its points are raised onto the body
_KEPT = 24  # places whose presses are kept
_LEAST = 1e-7  # m between presses that a slope is taken from
_RISE = 1.5  # power of depth that a force about grows with
_GRAZE = 2e-5  # m of travel; a touch that is lighter has no mesh fine enough, and the shape of this one
_LIGHT = 2e-4  # m of travel up to which one twice as deep stands in for a press that cannot be solved
_SAME = 1e-9  # tolerance over the travel


class SheetFidelity:
    """The sheet solver with the membrane effects that are on."""

    def __init__(
        self,
        width: float,
        gauge: float,
        thickness: float,
        material: Material,
        mount_prestretch: float,
        effects: Iterable[MembraneEffect] = (),
        settings: Settings | None = None,
        stats: Stats | None = None,
    ) -> None:
        self.stats = stats or Stats()
        on = Effects()
        for effect in effects:
            on = effect.on_sheet(on)
        self.sheet = Sheet(gauge, width, thickness, material, mount_prestretch, on)
        self.settings = settings or Settings()  # exact, so that a force does not depend on earlier solves
        #: for shapes that a camera sees: mostly within 0.01 mm, at most 0.04 mm, of the exact shape on the same mesh, in a third of the time
        self._seen = replace(self.settings, exact=False, corrected=False)
        #: for touches so light that rounding is in the way of an exact balance: within 5 % of a hundredth of a newton
        self._touching = replace(self.settings, exact=False)
        self.remembers = on.mullins is not None or on.friction > 0
        self.close = _FELT if self.remembers else _KNOWN
        self._curves: OrderedDict[Place, Curve] = OrderedDict()
        self._last: OrderedDict[Place, _Last] = OrderedDict()
        self.resting = lru_cache(maxsize=_KEPT)(self._resting)
        self._hang = lru_cache(maxsize=_KEPT)(self._hang_at)
        self._lift = lru_cache(maxsize=_KEPT)(self._lift_at)

    def law(self, place: Place, state: Any) -> Law:
        """Return the force between solved depths, or of a solve at each depth where the membrane remembers."""
        if self.remembers:
            return self._felt(place, state)
        return self._curve(place)

    def press(self, place: Place, depth: float, state: Any) -> Pressed:
        """Return the solved shape."""
        solved = self._solve(place, depth, state, seen=not self.remembers)
        reached = solved.load == self._load(place, depth)  # a deeper one that stands in for it was not
        skin = Grid(solved.points_outside(*_counts(solved.shape)))
        return Pressed(skin, (solved if reached else state) if self.remembers else None)

    def force(self, place: Place, depth: float, state: Any) -> Array:
        """Return the force, off centre or tilted with a part across."""
        return self._solved_force(place, depth, state) if self.remembers else self._curve(place).force(depth)

    def released(self, state: Any) -> Any:
        """Return the softening alone; without contact nothing slides on, so that friction begins anew."""
        return state.let_go() if state is not None and self.sheet.effects.mullins is not None else None

    def lift(self, place: Place) -> float:
        """Return how far the membrane hangs, m, over the top of a body, or over that part of it where it hangs most."""
        return self._lift(place) if self.sheet.effects.sag and place.body is not None else 0.0

    def _lift_at(self, place: Place) -> float:
        from stretch_bt.simulation.membrane.sheet.hanging import lift

        assert place.body is not None
        body = turn(place.body, place.heading)
        return lift(self._hang(place.stretch), self.sheet, place.stretch, body, place.at)

    def _hang_at(self, stretch: float) -> RegularGridInterpolator:
        from stretch_bt.simulation.membrane.sheet.hanging import profile

        return profile(self.resting(stretch))

    def free(self, stretch: float) -> Skin:
        """Return the membrane as it hangs, flat when it has no weight, narrower in its middle when stretched."""
        shape = self.resting(stretch)
        return Grid(np.ascontiguousarray(shape.points(*_counts(shape))))

    def _resting(self, stretch: float) -> Shape:
        from stretch_bt.simulation.membrane.sheet.hanging import hang

        return hang(self.sheet, stretch)

    def _felt(self, place: Place, state: Any) -> Law:
        """Return a law that solves at each depth; its slope is a power law's first, then the one between solves."""
        solved: list[tuple[float, float]] = []

        def law(depth: float) -> tuple[float, float]:
            travel = depth + self.lift(place)
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
        """Return the force (3,), N, of a solve; where it is too light for one, by the power law through two that are not."""
        solved = self._solve(place, depth, state)
        part = (depth + self.lift(place)) / solved.load.travel
        if part >= 1 - _SAME:
            return solved.force
        deeper = self._solve(place, depth + (2 - part) * solved.load.travel, state)
        forces = max(float(solved.force[2]), 0.0), float(deeper.force[2])
        power = math.log2(forces[1] / forces[0]) if 0 < forces[0] < forces[1] else _RISE
        return np.asarray(solved.force * part ** max(power, 1.0))

    def _curve(self, place: Place) -> Curve | Between:
        """Return the force of a body; for a ball whose radius varies, the force between balls of fixed radii."""
        if place.varies and isinstance(place.body, Sphere):
            # without the form, which varies as the ball does and would be another place each time
            return Between(place.body, lambda ball: self._fixed(replace(place, body=ball, form=None, varies=False)))
        return self._fixed(place)

    def _fixed(self, place: Place) -> Curve:
        if place not in self._curves:
            made = Curve(lambda depth: self._solved_force(place, depth, None), self.lift(place))
            _keep(self._curves, place, made)
        return self._curves[place]

    def _solve(self, place: Place, depth: float, state: Any, *, seen: bool = False) -> SheetPress:
        """Solve from the membrane's memory, else from the last press at the same place, else from flat.

        A shape that is only `seen` need not be exact.
        """
        load = self._load(place, depth)
        known = state if self.remembers else None
        last = self._last.get(place)
        if last is not None and last.known is known and last.asked == load and (seen or not last.seen):
            return last.solved
        start = known if self.remembers else last.solved if last is not None else None
        if start is not None and not goes_on_as(start.load.indenter, load.indenter):
            start = start.let_go()  # friction remembers how one body slid
        with self.stats.timed("solve"):
            solved = self._balanced(load, start, self._quick(place, load, seen))
        _keep(self._last, place, _Last(known, load, solved, seen))
        return solved

    def _quick(self, place: Place, load: Load, seen: bool) -> tuple[Settings, ...]:
        """Return the settings to try before exact ones."""
        if self.remembers or not (self.settings.exact or place.passing):
            return ()
        if place.passing or seen:
            return (_PASSING if place.passing else self._seen,)
        return (self._touching,) if load.travel <= _TOUCH else ()

    def _balanced(self, load: Load, start: SheetPress | None, first: tuple[Settings, ...] = ()) -> SheetPress:
        """Return a press; a touch that is too light to be distinguished from the rounding of energies gives way to a deeper one."""
        from stretch_bt.simulation.membrane.sheet.solver import solve

        failure: NoEquilibrium | None = None
        for settings in (*first, self.settings, _LOOSE):  # the latter where forces cannot balance exactly
            try:
                solved = solve(self.sheet, load, settings, start)
            except Impossible:
                raise
            except NoEquilibrium as error:
                failure = failure or error
            else:
                self.stats.counts["solve to 1 %"] += settings is _LOOSE
                return solved
        assert failure is not None
        if load.travel > _LIGHT:
            raise failure
        return self._balanced(replace(load, depth=load.depth + load.travel), start, first)

    def _load(self, place: Place, depth: float) -> Load:
        from stretch_bt.simulation.membrane.sheet.result import Load

        if place.body is None:
            raise NoEquilibrium(
                "an object wider than the membrane meets the fingers; only hertz fidelity has an answer"
            )
        body, lift = turn(place.body, place.heading), self.lift(place)
        return Load(body, place.stretch, max(depth, _GRAZE - lift), place.at, place.tilt, lift)


@dataclass(frozen=True, slots=True)
class _Last:
    """The press last solved at a place: the membrane's memory before it, the load as asked for, and whether only to be seen."""

    known: Any
    asked: Load
    solved: SheetPress
    seen: bool


def _keep(kept: OrderedDict[Any, Any], key: Any, value: Any) -> None:
    kept[key] = value
    kept.move_to_end(key)
    while len(kept) > _KEPT:
        kept.popitem(last=False)


def _counts(shape: Shape) -> tuple[int, int]:
    """Return how many columns and rows a grid has that is even on the unstretched sheet."""
    columns, rows = (round((a.breaks[-1] - a.breaks[0]) * shape.unit / PITCH) + 1 for a in (shape.mesh.x, shape.mesh.y))
    return columns, rows
