"""The simulated world: what a scene comes to when the hand stands somewhere, worked out when somebody looks."""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.simulation.advisor.advise import advise, switch_on
from stretch_bt.simulation.camera.skin import Grid, Skin
from stretch_bt.simulation.coupling import Equilibrium, couple
from stretch_bt.simulation.effects import Active
from stretch_bt.simulation.effects.base import MembraneEffect
from stretch_bt.simulation.fidelity.base import Place
from stretch_bt.simulation.fidelity.make import Membrane, make_fidelity
from stretch_bt.simulation.hanging import between, hung, pulled_by
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.objects.base import Moved, ObjectSpec, Standing
from stretch_bt.simulation.objects.response import Law
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.seat import Seat, seat
from stretch_bt.simulation.stats import Stats

__all__ = ["Contact", "World"]

_KEPT = 8  # contacts that are kept
_STRIDE = 0.1  # s; a membrane that remembers is taken along its path in steps that each take few iterations
_GROWTH = 1.5  # power of its depth that the force of a membrane about grows with
_AGE = 2.5  # s for which the memory is kept, for what is asked of a moment ago
_CREEP = 4e-6  # m; a shape that changes by itself is drawn in steps of this, far below what a camera tells apart
_SETTLED = 1e-6  # m; a body that changes its shape with its drop is met anew until the drop changes by less
_PASSES = 30
_FRAME = 2e4  # N/m, of the hand's frame where something meets it
_SWINGS = 8  # passes after which the drop is taken to swing about its value


@dataclass(frozen=True, slots=True)
class Contact:
    """How membrane and object stand: lengths in m; `depth` and `drop` are 0 while they do not touch.

    `force` (3,), N, is that of the object on the hand, world axes, solved at `felt`, and its shape is that at `place`;
    `remembered` is what the membrane knew before. An object that sticks to a hand above it pulls the membrane down by `pulled`, and
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
class _Past:
    """What the world remembers of a moment, s: the object's state, the membrane's, where the hand was, and how far
    it was past first contact with what drop; m. `number` is that of the change that led to it.
    """

    time: float
    thing: Any
    membrane: Any
    at: tuple[float, float]
    hand: tuple[Pose, float] | None = None
    shared: tuple[float, float] | None = None
    number: int = 0


class World:
    """A scene and a hand over it.

    Where neither object nor membrane has a memory it is a pure function of the hand's pose and stretch, and time does not
    matter; else `advance` takes it from moment to moment, and what is asked in between changes nothing.
    """

    def __init__(self, scene: Scene, membrane: Membrane | None = None, seed: int = 0) -> None:
        self.scene = scene
        self.seed = seed
        self.membrane = membrane or Membrane()
        self.verdicts = advise(scene)
        self.effects = switch_on(scene, self.verdicts)
        self.specimen = scene.object.specimen(self.effects)
        self.stats = Stats()
        on = self.effects.of(MembraneEffect)  # type: ignore[type-abstract]
        self.fidelity = make_fidelity(scene, self.membrane, on, self.stats)
        self._past: deque[_Past] = deque([_Past(-math.inf, self.specimen.start(seed), self._conditioned(), (0.0, 0.0))])
        self._known: OrderedDict[Any, Contact] = OrderedDict()
        self._skin: tuple[Any, Any, Skin] | None = None

    def _conditioned(self) -> Any:
        """Return what the membrane remembers of the press that the scene's hand had before the task."""
        before = self.scene.hand.conditioned
        if before is None or not self.fidelity.remembers:
            return None
        radius = before.diameter / 2
        place = Place(Sphere(before.diameter), None, (0.0, 0.0), 0.0, (0.0, 0.0), radius, before.stretch)
        return self.fidelity.released(self.fidelity.press(place, before.depth, None).state)

    def exchange(self, spec: ObjectSpec) -> None:
        """Put another object, as it is at the begin of a run, in the place of the present one.

        What the membrane remembers stays, and so does which effects act, those aside that the new object cannot have.

        Raises
        ------
        InvalidInput
            Nothing stands in for it at the scene's fidelity; all stays as it was.
        """
        scene = self.scene.with_(object=spec, dimensions={})
        if not scene.stands_in():
            raise InvalidInput(f"nothing stands in for a {spec.type} at {scene.fidelity} fidelity; use fidelity: sheet")
        specimen = spec.specimen(Active(e for e in self.effects if e.refusal(spec) is None))
        past = self._past[-1]
        kept = self.fidelity.released(past.membrane)
        self.scene, self.specimen = scene, specimen
        self._past.clear()
        self._past.append(_Past(past.time, specimen.start(self.seed), kept, past.at, number=past.number + 1))
        self._known.clear()

    @property
    def memory(self) -> float | None:
        """None without one; infinite where only the path counts; else the longest step of time, s."""
        own = self.specimen.memory
        if not self.fidelity.remembers:
            return own
        return _STRIDE if own is None else min(own, _STRIDE)

    @property
    def latest(self) -> float:
        """The last moment, s, that the memory was taken to; minus infinity before any."""
        return self._past[-1].time

    def contact(self, pose: Pose, stretch: float, time: float = 0.0) -> Contact:
        """Return how membrane and object stand; solved once for each new pose and stretch after a change, and moment where time counts.

        Raises
        ------
        NoEquilibrium
            There is none: the object meets the membrane's border, wraps into it, or would be pressed flat. What was solved
            before stays.
        """
        past = self._before(time)
        key = (pose, stretch, past.number, None if self.specimen.timeless else (past.time, time))
        if key in self._known:
            self._known.move_to_end(key)
            return self._known[key]
        with self.stats.timed("contact"):
            found = self._solve(past, pose, stretch, time)
        self._known[key] = found
        while len(self._known) > _KEPT:
            self._known.popitem(last=False)
        return found

    def advance(self, pose: Pose, stretch: float, time: float) -> None:
        """Take the world's memory to a moment, s, at which the hand stands there; the path from the last one is straight.

        Raises
        ------
        NoEquilibrium
            There is none there; the memory goes on from that moment as it was.
        """
        if self.memory is None or time <= self._past[-1].time:
            return
        past = self._past[-1]
        if past.hand == (pose, stretch) and self.specimen.timeless:
            self._remember(replace(past, time=time))  # without a way nothing changes
            return
        at = (pose.position[0], pose.position[1])
        try:
            contact = self.contact(pose, stretch, time)
        except NoEquilibrium:
            self._remember(replace(past, time=time, at=at, hand=(pose, stretch), shared=None, number=past.number + 1))
            raise
        with self.stats.timed("memory"):
            across = (at[0] - past.at[0], at[1] - past.at[1]) if math.isfinite(past.time) else (0.0, 0.0)
            dt = time - past.time if math.isfinite(past.time) else 0.0
            x, y, z = contact.force
            moved = Moved(contact.drop, (-x, -y, -z), across, dt, contact.depth, contact.raised)
            thing = self.specimen.after(past.thing, moved)
            state = self.fidelity.released(past.membrane)
            if contact.felt is not None and self.fidelity.remembers:
                state = self.fidelity.press(contact.felt, contact.depth, past.membrane).state
            shared = (contact.depth + contact.drop, contact.drop) if contact.place is not None else None
            self._remember(_Past(time, thing, state, at, (pose, stretch), shared, past.number + 1))

    def _remember(self, past: _Past) -> None:
        """Keep a moment, and those before it that may still be asked for."""
        self._past.append(past)
        while len(self._past) > 1 and self._past[1].time < past.time - _AGE:
            self._past.popleft()

    def skin(self, contact: Contact, stretch: float) -> Skin:
        """Return the shape of the membrane; while an object creeps under it, that within 2 um of its depth."""
        depth = contact.depth if self._still else round(contact.depth / _CREEP) * _CREEP
        key = stretch, contact.place, depth
        if self._skin is None or self._skin[0] != key or self._skin[1] is not contact.remembered:
            with self.stats.timed("shape"):
                self._skin = (key, contact.remembered, self._shape(replace(contact, depth=depth), stretch))
        return self._skin[2]

    @property
    def _still(self) -> bool:
        """Whether shapes change by motion alone, or each is solved for its force anyway."""
        return self.specimen.timeless or self.fidelity.remembers

    def standing(self, drop: float = 0.0) -> Standing:
        """Return what the membrane meets of the object after a drop of its top, m, by the latest memory."""
        state = self._past[-1].thing
        standing, grip = self.specimen.standing(state, drop), self.specimen.grip(state)
        return standing if grip is None else replace(standing, top=standing.top + grip.raised)

    def lift(self, pose: Pose, stretch: float) -> float:
        """Return how far the membrane hangs where it meets the object, m, by the latest memory."""
        standing = self.standing()
        return self._lift(standing, seat(standing, pose), stretch)

    def _lift(self, standing: Standing, where: Seat, stretch: float) -> float:
        return self.fidelity.lift(self._felt(standing, where, stretch))

    def _shape(self, contact: Contact, stretch: float) -> Skin:
        if contact.place is None:
            return self.fidelity.free(stretch)
        if contact.raised is None:
            return self.fidelity.press(contact.place, contact.depth, contact.remembered).skin
        up = contact.pulled - self.fidelity.lift(contact.place)
        free, pushed = self.fidelity.free(stretch), self.fidelity.press(contact.place, up, contact.remembered).skin
        assert isinstance(free, Grid)
        assert isinstance(pushed, Grid)
        return hung(free, pushed)

    def truth(self, pose: Pose, stretch: float, time: float = 0.0) -> dict[str, float]:
        """Return what a perfect observer would report, SI; a rigid object has no stiffness.

        The scene's `dimensions` are among it. `height` is that of the object's top and `contact_height` that of the hand at first
        contact.
        """
        contact = self.contact(pose, stretch, time)
        top = self.specimen.standing(self._before(time).thing, 0.0).top
        return {
            **self.specimen.known(self._before(time).thing, contact.drop),
            **self.scene.dimensions,
            "force": math.hypot(*contact.force),
            "deflection": contact.drop,
            "stretch": stretch,
            "depth": contact.depth,
            "height": top - contact.drop + (contact.raised or 0.0),
            "contact_height": self.scene.object.top,
        }

    def sketch(self, time: float) -> dict[str, list[tuple[float, float]]]:
        """Return lines, m, that show the object as it was at a time, s; none of one that keeps its shape."""
        return self.specimen.sketch(self._before(time).thing)

    def _before(self, time: float) -> _Past:
        """Return the latest memory that is not after a moment."""
        return next((past for past in reversed(self._past) if past.time <= time), self._past[0])

    def _solve(self, past: _Past, pose: Pose, stretch: float, time: float) -> Contact:
        state, dt = past.thing, time - past.time if math.isfinite(past.time) else 0.0
        standing = self.specimen.standing(state, 0.0)
        where = seat(standing, pose)
        rest = self.specimen.rest(state, dt)
        nothing = Contact(0.0, rest, (0.0, 0.0, 0.0))
        if where.depth + self._lift(standing, where, min(stretch, 0.0)) <= 0:  # slack it hangs most
            return self._pulling(past, standing, pose, stretch) or nothing
        lift = self._lift(standing, where, stretch)
        if where.depth + lift <= 0 or not self._covers(where, stretch):
            return self._pulling(past, standing, pose, stretch) or nothing
        found, standing = self._shared(past, standing, where, stretch, dt, lift, rest)
        if found.force <= 0:
            return self._pulling(past, standing, pose, stretch) or replace(nothing, drop=found.drop)
        depth = found.depth - lift
        felt = self._felt(standing, where, stretch)
        pushed = self.fidelity.force(felt, depth, past.membrane) + np.array([0.0, 0.0, self._framed(depth)[0]])
        force = _world(pushed, pose)
        place = self._place(standing, where, stretch)
        return Contact(depth, found.drop, force, place, felt, past.membrane, found.iterations)

    def _pulling(self, past: _Past, standing: Standing, pose: Pose, stretch: float) -> Contact | None:
        """Return how an object that sticks pulls at a hand above it, None where none does."""
        grip = self.specimen.grip(past.thing)
        if grip is None:
            return None
        if grip.raised:  # since the last moment it went with the hand
            x, y = pose.position[0] - past.at[0], pose.position[1] - past.at[1]
            standing = replace(standing, x=standing.x + x, y=standing.y + y)
        where = seat(standing, pose)
        if where.upright != 1.0 or not self._covers(where, stretch):
            return None
        spot = Place(grip.spot, None, where.at, 0.0, (0.0, 0.0), self.scene.object.reach, stretch)
        above = max(-where.depth - self.fidelity.lift(spot), 0.0)
        found = pulled_by(between(stretch, lambda known: self._pull_law(spot, known, past)), grip, above)
        if found is None:
            return None
        force = _world(np.array([0.0, 0.0, -found.force]), pose)
        depth = where.depth + found.raised
        return Contact(depth, 0.0, force, spot, None, past.membrane, 0, found.down, found.raised)

    def _pull_law(self, spot: Place, stretch: float, past: _Past) -> Law:
        """Return the force on a spot in the middle of the membrane by how far that is moved from where it hangs freely."""
        middle = replace(spot, at=(0.0, 0.0), stretch=stretch)
        return _lifted(self.fidelity.law(middle, past.membrane), self.fidelity.lift(middle))

    def _shared(
        self, past: _Past, standing: Standing, where: Seat, stretch: float, dt: float, lift: float, rest: float
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
        for turn in range(_PASSES):
            found = couple(
                _lifted(felt, lift), own, travel, rest=rest * upright, start=start, kinks=kinks, close=close, near=near
            )
            spent, before, drop = spent + found.iterations, drop, found.drop / upright
            changed = self.specimen.standing(state, drop)
            if changed.body == standing.body or abs(drop - before) < _SETTLED:
                return found._replace(iterations=spent, drop=drop), changed
            # drops that swing to and fro, as where friction holds, are met in their middle
            standing = changed if turn < _SWINGS else self.specimen.standing(state, (drop + before) / 2)
            felt = self._hand_law(standing, where, stretch, past)
        raise NoEquilibrium("membrane and object do not agree on the object's shape")

    def _hand_law(self, standing: Standing, where: Seat, stretch: float, past: _Past) -> Law:
        """Return the hand's force by depth: that of the membrane, and of the frame behind it where it has one."""
        law = self.fidelity.law(self._felt(standing, where, stretch), past.membrane)
        if self.scene.hand.frame is None:
            return law

        def both(depth: float) -> tuple[float, float]:
            (soft, slope), (hard, steep) = law(depth), self._framed(depth)
            return soft + hard, slope + steep

        return both

    def _framed(self, depth: float) -> tuple[float, float]:
        """Return the force, N, of the hand's frame on what stands this deep in it, and its slope, N/m."""
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
        """Return the place at which a force is felt: that of a simpler body, if there is one, in the middle of the membrane."""
        place = self._place(standing, where, stretch)
        if standing.felt is None or place.tilt != (0.0, 0.0):
            return place
        return replace(place, body=standing.felt, at=(0.0, 0.0), heading=0.0, passing=False)

    def _covers(self, where: Seat, stretch: float) -> bool:
        """Tell whether the object stands under the membrane, at least in part."""
        reach = self.scene.object.reach
        length = self.membrane.gauge + self.scene.hand.mount_prestretch + stretch
        borders = (self.membrane.width / 2, length / 2)
        return all(abs(a) <= border + reach for a, border in zip(where.at, borders, strict=True))


def _ahead(past: _Past, travel: float) -> float | None:
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
