"""The simulated world: the contact of hand and object wherever the hand stands, worked out when somebody looks."""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from dataclasses import replace
from typing import Any

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.simulation.advisor.advise import switch_on
from stretch_bt.simulation.advisor.choose import choose
from stretch_bt.simulation.camera.skin import Grid, Skin
from stretch_bt.simulation.effects import Active
from stretch_bt.simulation.effects.base import MembraneEffect
from stretch_bt.simulation.fidelity.base import Place
from stretch_bt.simulation.fidelity.make import Membrane, make_fidelity
from stretch_bt.simulation.fidelity.rungs import RUNGS
from stretch_bt.simulation.hanging import hung
from stretch_bt.simulation.meeting import Contact, Meeting, Past
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.objects.base import Moved, ObjectSpec, Standing
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.stats import Stats

__all__ = ["Contact", "World"]

_KEPT = 8  # contacts that are kept
_STRIDE = 0.1  # s; a membrane that remembers is taken along its path in steps that each take few iterations
_AGE = 2.5  # s for which the memory is kept, for questions about a moment ago
_CREEP = 4e-6  # m; a shape that changes by itself is drawn in steps of this, far below what a camera distinguishes


class World:
    """A scene and a hand over it.

    Where neither object nor membrane has a memory it is a pure function of the hand's pose and stretch, and time does not
    matter; else `advance` takes it from moment to moment, and questions in between leave its memory alone. The solver starts a shape that only
    a camera sees from the one solved last at its place: by where it starts it may differ by some 0.01 mm. The sheet is solved exactly, or
    to `within`, a part of the force, or else with the settings that the advisor chose.
    """

    def __init__(
        self,
        scene: Scene,
        membrane: Membrane | None = None,
        seed: int = 0,
        within: float | None = None,
        settings: Settings | None = None,
    ) -> None:
        self.scene = scene
        self.seed = seed
        self.membrane = membrane or Membrane()
        self.chosen = choose(scene)
        self.effects = switch_on(scene, self.chosen)
        self.specimen = scene.object.specimen(self.effects)
        self.stats = Stats()
        on = self.effects.of(MembraneEffect)  # type: ignore[type-abstract]
        if settings is None and self.chosen.rung is not None:
            settings = RUNGS[self.chosen.rung] if within is None else Settings.within(within)
        self.fidelity = make_fidelity(scene, self.membrane, on, self.stats, settings)
        self._meeting = Meeting(scene, self.membrane, self.fidelity, self.specimen)
        self._past: deque[Past] = deque([Past(-math.inf, self.specimen.start(seed), self._conditioned(), (0.0, 0.0))])
        self._known: OrderedDict[Any, Contact] = OrderedDict()
        self._skin: tuple[Any, Any, Skin] | None = None

    def _conditioned(self) -> Any:
        """Return the membrane's memory of the press that the scene's hand had before the task."""
        before = self.scene.hand.conditioned
        if before is None or not self.fidelity.remembers:
            return None
        radius = before.diameter / 2
        place = Place(Sphere(before.diameter), None, (0.0, 0.0), 0.0, (0.0, 0.0), radius, before.stretch)
        depth = before.depth - self.fidelity.lift(place)  # it counts from first contact, where the membrane hangs
        return self.fidelity.released(self.fidelity.press(place, depth, None).state)

    def exchange(self, spec: ObjectSpec) -> None:
        """Put another object, as it is at the begin of a run, in the place of the present one.

        The membrane's memory stays, and so do the effects that act, except effects that the new object cannot have.

        Raises
        ------
        InvalidInput
            Nothing stands in for it at the scene's fidelity; all stays as it was.
        """
        scene = self.scene.with_(object=spec, dimensions={})
        if not scene.stands_in():
            raise InvalidInput(f"nothing stands in for {spec.noun} at {scene.fidelity} fidelity; use fidelity: sheet")
        specimen = spec.specimen(Active(e for e in self.effects if e.refusal(spec) is None))
        past = self._past[-1]
        kept = self.fidelity.released(past.membrane)
        self.scene, self.specimen = scene, specimen
        self._meeting = Meeting(scene, self.membrane, self.fidelity, specimen)
        self._past.clear()
        self._past.append(Past(past.time, specimen.start(self.seed), kept, past.at, number=past.number + 1))
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

    def buried(self, pose: Pose, stretch: float) -> float:
        """Return how far the object stands out above the plane of a membrane over it, m, as it is now."""
        return self._meeting.buried(self._past[-1].thing, pose, stretch)

    def contact(self, pose: Pose, stretch: float, time: float = 0.0) -> Contact:
        """Return how membrane and object stand; solved once for each new pose and stretch after a change, and moment where time counts.

        Raises
        ------
        NoEquilibrium
            There is none: the object meets the membrane's border, wraps into it, or would be pressed flat. Earlier solutions
            stay.
        """
        past = self._before(time)
        key = (pose, stretch, past.number, None if self.specimen.timeless else (past.time, time))
        if key in self._known:
            self._known.move_to_end(key)
            return self._known[key]
        with self.stats.timed("contact"):
            found = self._meeting.contact(past, pose, stretch, time)
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
            self._remember(Past(time, thing, state, at, (pose, stretch), shared, past.number + 1))

    def _remember(self, past: Past) -> None:
        """Keep a moment, and those before it that may still be asked for."""
        self._past.append(past)
        while len(self._past) > 1 and self._past[1].time < past.time - _AGE:
            self._past.popleft()

    def skin(self, contact: Contact, stretch: float) -> Skin:
        """Return the shape of the membrane; while an object creeps under it, that within 2 um of its depth."""
        depth = contact.depth if self._still else round(contact.depth / _CREEP) * _CREEP
        key = stretch, contact.place, depth, contact.pulled
        if self._skin is None or self._skin[0] != key or self._skin[1] is not contact.remembered:
            with self.stats.timed("shape"):
                self._skin = (key, contact.remembered, self._shape(replace(contact, depth=depth), stretch))
        return self._skin[2]

    @property
    def _still(self) -> bool:
        """Whether shapes change by motion alone, or each is solved for its force anyway."""
        return self.specimen.timeless or self.fidelity.remembers

    def standing(self, drop: float = 0.0) -> Standing:
        """Return the body that the membrane meets after a drop of its top, m, by the latest memory."""
        state = self._past[-1].thing
        standing, grip = self.specimen.standing(state, drop), self.specimen.grip(state)
        return standing if grip is None else replace(standing, top=standing.top + grip.raised)

    def lift(self, pose: Pose, stretch: float) -> float:
        """Return how far the membrane hangs, m, where it would meet the object if the hand went down, by the latest memory."""
        return self._meeting.hangs(self.standing(), pose, stretch)

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
        """Return the true quantities, SI; a rigid object has no stiffness.

        The scene's `dimensions` are among it. `height` is the height of the object's top, of several objects the highest beneath the hand, and
        `contact_height` the hand's at first contact.
        """
        contact = self.contact(pose, stretch, time)
        thing = self._before(time).thing
        top = self._meeting.highest_below(thing, pose, stretch)
        return {
            **self.specimen.known(thing, contact.drop),
            **self.scene.dimensions,
            "force": float(pose.matrix()[:, 2] @ contact.force),  # along the hand's axis, as nodes measure it
            "deflection": contact.drop,
            "stretch": stretch,
            "depth": contact.depth,
            "height": top - contact.drop + (contact.raised or 0.0),
            "contact_height": self.scene.object.top + top - self.specimen.standing(thing, 0.0).top,
        }

    def sketch(self, time: float) -> dict[str, list[tuple[float, float]]]:
        """Return lines, m, that show the object as it was at a time, s; none of one that keeps its shape."""
        return self.specimen.sketch(self._before(time).thing)

    def _before(self, time: float) -> Past:
        """Return the latest memory that is not after a moment."""
        return next((past for past in reversed(self._past) if past.time <= time), self._past[0])
