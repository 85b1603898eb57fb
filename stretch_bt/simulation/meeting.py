"""How a hand that stands somewhere and an object meet: which of them gives way by how much, with which force, and whether they stick."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.simulation.beneath import beneath
from stretch_bt.simulation.camera.skin import Grid
from stretch_bt.simulation.coupling import Equilibrium, couple
from stretch_bt.simulation.fidelity.base import Fidelity, Place
from stretch_bt.simulation.fidelity.make import Membrane
from stretch_bt.simulation.hanging import between, pulled_by
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.objects.base import Specimen, Standing
from stretch_bt.simulation.objects.response import Law
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.seat import Seat, seat

__all__ = ["Contact", "Meeting", "Past"]

_GROWTH = 1.5  # power of its depth that the force of a membrane about grows with
_SETTLED = 1e-6  # m; a body that changes its shape with its drop is met anew until the drop changes by less
_PASSES = 30
_FRAME = 2e4  # N/m, stiffness of the hand's frame where something meets it
_LOOSER = 10.0  # tolerance of the way of a pull over the tolerance of shared travel
_KEPT = 8  # stretches, of which the free membrane is kept
_WELL_INSIDE = 0.6  # of half the membrane's sides, within which it is under any stretch
_SWINGS = 8  # passes after which the drop is taken to swing about its value


@dataclass(frozen=True, slots=True)
class Contact:
    """How membrane and object stand: lengths in m; `depth` and `drop` are 0 while they do not touch.

    `force` (3,), N, acts from the object on the hand, world axes, solved at `felt`, and the shape is solved at `place`;
    `remembered` is the membrane's memory before. An object that sticks to a hand above it pulls the membrane down by `pulled`, and
    hangs `raised` above where it stood; `raised` is None where it does not pull.
    """

    depth: float
    drop: float
    force: tuple[float, float, float]
    place: Place | None = None
    felt: Place | None = None
    remembered: Any = None
    iterations: int = 0
    pulled: float = 0.0
    raised: float | None = None


@dataclass(frozen=True, slots=True)
class Past:
    """The world's memory of a moment, s: the object's state, the membrane's, where the hand was, and how far
    it was past first contact with which drop; m. `number` counts the change that led to it.
    """

    time: float
    thing: Any
    membrane: Any
    at: tuple[float, float]
    hand: tuple[Pose, float] | None = None
    shared: tuple[float, float] | None = None
    number: int = 0


class Meeting:
    """A hand over one object, whose states the world keeps."""

    def __init__(self, scene: Scene, membrane: Membrane, fidelity: Fidelity, specimen: Specimen) -> None:
        self.scene, self.membrane, self.fidelity, self.specimen = scene, membrane, fidelity, specimen
        self._free = lru_cache(maxsize=_KEPT)(self._free_at)

    def contact(self, past: Past, pose: Pose, stretch: float, time: float) -> Contact:
        """Return how hand and object stand at a moment after the past one; raises NoEquilibrium."""
        state, dt = past.thing, time - past.time if math.isfinite(past.time) else 0.0
        rest = self.specimen.rest(state, dt)
        nothing = Contact(0.0, rest, (0.0, 0.0, 0.0))
        carried = self._carried(past, pose)
        # what sticks may pull a membrane that it is below
        standing = carried if self.specimen.grip(state) else self._met(carried, pose, stretch)
        if standing is None:
            return nothing
        where = seat(standing, pose)
        if where.depth + self.lift(standing, where, min(stretch, 0.0)) <= 0:  # slack it hangs most
            return self._pulling(past, standing, pose, stretch) or nothing
        lift = self.lift(standing, where, stretch)
        if where.depth + lift <= 0 or not self._covers(where, stretch):
            return self._pulling(past, standing, pose, stretch) or nothing
        found, standing = self._shared(past, standing, where, stretch, dt, lift, rest)
        if found.force <= 0:
            return self._pulling(past, standing, pose, stretch) or replace(nothing, drop=max(found.drop, rest))
        depth = found.depth - lift
        felt = self._felt(standing, where, stretch)
        pushed = self.fidelity.force(felt, depth, past.membrane) + np.array([0.0, 0.0, self._framed(depth)[0]])
        force = _world(pushed, pose)
        place = self._place(standing, where, stretch)
        return Contact(depth, found.drop, force, place, felt, past.membrane, found.iterations)

    def buried(self, state: Any, pose: Pose, stretch: float) -> float:
        """Return how far an object beneath the hand stands out above the plane of the membrane, m; 0 where it does not."""
        standing = self._met(self.specimen.standing(state, 0.0), pose, stretch)
        where = None if standing is None else seat(standing, pose)
        return 0.0 if where is None or not self._covers(where, stretch) else max(where.depth, 0.0)

    def highest_below(self, state: Any, pose: Pose, stretch: float) -> float:
        """Return the world height of the highest top that the hand would meet if it went down, m; without one, the object's."""
        return self._below(self.specimen.standing(state, 0.0), pose, stretch).top

    def hangs(self, standing: Standing, pose: Pose, stretch: float) -> float:
        """Return how far the membrane hangs, m, where it would meet the object if the hand went down."""
        met = self._below(standing, pose, stretch)
        return self.lift(met, seat(met, pose), stretch)

    def _below(self, standing: Standing, pose: Pose, stretch: float) -> Standing:
        """Return the standing object, of several bodies those that the hand would meet if it went down, all where it would meet none."""
        return self._met(standing, pose.at_height(self.scene.object.base), stretch) or standing

    def _met(self, standing: Standing, pose: Pose, stretch: float) -> Standing | None:
        """Return the standing object, of several bodies the ones that the membrane can meet; None where it meets none of them."""
        free = self._free(stretch) if self._may_miss(standing, pose, stretch) else None
        return standing if free is None else beneath(standing, pose, free)

    def _may_miss(self, standing: Standing, pose: Pose, stretch: float) -> bool:
        """Return whether a body may stand beside the membrane: it is one of several, or its axis is far from the middle."""
        if standing.body is None or isinstance(standing.body, Several):
            return standing.body is not None
        at = seat(standing, pose).at
        return any(abs(a) > _WELL_INSIDE * border for a, border in zip(at, self._borders(stretch), strict=True))

    def _free_at(self, stretch: float) -> np.ndarray | None:
        """Return the points (rows, columns, 3), m, of the membrane that touches nothing; None of one that knows no border."""
        skin = self.fidelity.free(stretch)
        return skin.points if isinstance(skin, Grid) else None

    def lift(self, standing: Standing, where: Seat, stretch: float) -> float:
        """Return how far the membrane hangs where it meets the object, m."""
        return self.fidelity.lift(self._felt(standing, where, stretch))

    def _pulling(self, past: Past, standing: Standing, pose: Pose, stretch: float) -> Contact | None:
        """Return how an object that sticks pulls at a hand above it, None where none does."""
        grip = self.specimen.grip(past.thing)
        if grip is None:
            return None
        where = seat(standing, pose)
        if where.upright != 1.0 or not self._covers(where, stretch):
            return None
        spot = Place(grip.spot, None, where.at, 0.0, (0.0, 0.0), self.scene.object.reach, stretch)
        above = max(-where.depth - self.fidelity.lift(spot), 0.0)
        law = between(stretch, lambda known: self._pull_law(spot, known, past))
        found = pulled_by(law, grip, above, _LOOSER * self.fidelity.close)
        if found is None:
            return None
        force = _world(np.array([0.0, 0.0, -found.force]), pose)
        return Contact(0.0, 0.0, force, spot, None, past.membrane, 0, found.down, found.raised)

    def _carried(self, past: Past, pose: Pose) -> Standing:
        """Return the object that the membrane meets, m; an object that hung at the hand went with it since the last moment."""
        standing, grip = self.specimen.standing(past.thing, 0.0), self.specimen.grip(past.thing)
        if grip is None or not grip.raised:
            return standing
        x, y = pose.position[0] - past.at[0], pose.position[1] - past.at[1]
        return replace(standing, x=standing.x + x, y=standing.y + y)

    def _pull_law(self, spot: Place, stretch: float, past: Past) -> Law:
        """Return the force on a spot in the middle of the membrane by how far that is moved from where it hangs freely."""
        middle = replace(spot, at=(0.0, 0.0), stretch=stretch)
        return _lifted(self.fidelity.law(middle, past.membrane), self.fidelity.lift(middle))

    def _shared(
        self, past: Past, standing: Standing, where: Seat, stretch: float, dt: float, lift: float, rest: float
    ) -> tuple[Equilibrium, Standing]:
        """Return how the travel is shared; a body that changes its shape with its drop is met as it is at the drop found."""
        law = self.specimen.law(past.thing, dt)
        travel = where.depth + lift
        felt = self._hand_law(standing, where, stretch, past)
        if law is None:
            return Equilibrium(travel, 0.0, felt(where.depth)[0], 0), standing
        state, drop, spent, near = past.thing, math.inf, 0, _ahead(past, where.depth)
        own, close = _along(law, where.upright), self.fidelity.close
        upright = where.upright  # the part of a drop that is a way along the hand's axis
        kinks = [kink * upright for kink in self.specimen.kinks(state)]
        start = self.specimen.drop(state) * upright
        whole = self.specimen.standing(state, 0.0)  # of which the membrane may meet a part, on an axis of its own
        for turn in range(_PASSES):
            found = couple(
                _lifted(felt, lift), own, travel, rest=rest * upright, start=start, kinks=kinks, close=close, near=near
            )
            spent, before, drop = spent + found.iterations, drop, found.drop / upright
            changed = self.specimen.standing(state, drop)
            if changed.body == whole.body or abs(drop - before) < _SETTLED:
                # the body that balanced, at the drop found
                balanced = replace(standing, top=standing.top + changed.top - whole.top)
                return found._replace(iterations=spent, drop=drop), balanced
            # drops that swing to and fro, as where friction holds, are met in their middle
            standing = whole = changed if turn < _SWINGS else self.specimen.standing(state, (drop + before) / 2)
            felt = self._hand_law(standing, where, stretch, past)
        raise NoEquilibrium("membrane and object do not agree on the object's shape")

    def _hand_law(self, standing: Standing, where: Seat, stretch: float, past: Past) -> Law:
        """Return the hand's force by depth: the membrane's, and the frame's behind it where there is one."""
        law = self.fidelity.law(self._felt(standing, where, stretch), past.membrane)
        if self.scene.hand.frame is None:
            return law

        def both(depth: float) -> tuple[float, float]:
            (soft, slope), (hard, steep) = law(depth), self._framed(depth)
            return soft + hard, slope + steep

        return both

    def _framed(self, depth: float) -> tuple[float, float]:
        """Return the force, N, of the hand's frame on an object this deep in it, and its slope, N/m."""
        frame = self.scene.hand.frame
        if frame is None or depth <= frame:
            return 0.0, 0.0
        return _FRAME * (depth - frame), _FRAME

    def _place(self, standing: Standing, where: Seat, stretch: float) -> Place:
        form = self.specimen.form(standing)
        reach = self.scene.object.reach
        passing = standing.passing and where.tilt == (0.0, 0.0)
        return Place(standing.body, form, where.at, where.heading, where.tilt, reach, stretch, standing.varies, passing)

    def _felt(self, standing: Standing, where: Seat, stretch: float) -> Place:
        """Return the place at which a force is felt: a simpler body's, if there is one, in the middle of the membrane."""
        place = self._place(standing, where, stretch)
        if standing.felt is None or place.tilt != (0.0, 0.0):
            return place
        return replace(place, body=standing.felt, at=(0.0, 0.0), heading=0.0, passing=False)

    def _covers(self, where: Seat, stretch: float) -> bool:
        """Return whether the object stands under the membrane, at least in part."""
        reach = self.scene.object.reach
        return all(abs(a) <= border + reach for a, border in zip(where.at, self._borders(stretch), strict=True))

    def _borders(self, stretch: float) -> tuple[float, float]:
        """Return half the width and half the length, m, of the membrane where its clamps hold it."""
        length = self.membrane.gauge + self.scene.hand.mount_prestretch + stretch
        return self.membrane.width / 2, length / 2


def _ahead(past: Past, travel: float) -> float | None:
    """Return the drop, m, at a travel past first contact, as the last one known grows with the force."""
    if past.shared is None or min(past.shared) <= 0 or travel <= 0:
        return None
    return past.shared[1] * math.pow(travel / past.shared[0], _GROWTH)


def _lifted(felt: Law, lift: float) -> Law:
    """Return a membrane's law by how far it is past where it first touches."""
    return lambda travel: felt(travel - lift)


def _along(law: Law, upright: float) -> Law:
    """Return an object's law by the way and the force along the hand's axis, of which it feels the upright part."""
    if upright == 1.0:
        return law

    def along(way: float) -> tuple[float, float]:
        force, slope = law(way / upright)
        return force / upright, slope / upright**2

    return along


def _world(force: np.ndarray, pose: Pose) -> tuple[float, float, float]:
    """Return a force in the membrane frame in world axes; the membrane's y runs against the hand's."""
    x, y, z = (pose.matrix() @ np.array([force[0], -force[1], force[2]])).tolist()
    return x, y, z
