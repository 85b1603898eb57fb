"""The world that the simulated devices of one cell share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.motion.profile import Profile
from stretch_bt.hardware.simulated.placed import Placed
from stretch_bt.hardware.simulated.trace import Reported
from stretch_bt.hardware.simulated.track import Track
from stretch_bt.simulation.camera.sensor import Shot
from stretch_bt.simulation.effects import RobotEffect, registry
from stretch_bt.simulation.fidelity.make import Membrane
from stretch_bt.simulation.noise_source import noise_source
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.world import Contact, World

__all__ = ["Twin"]

_HOME = Pose((0.0, 0.0, 0.2))
_STRIDE = 0.1  # s; a bend, or a way across the object, is followed in steps of this where the path alone counts
_DEEPEST = 0.030  # m; greatest depth past first contact that a node may ask for


class Twin:
    """A scene, the hand over it, and what arm and gripper did; without an arm the hand hangs at a height of 200 mm.

    The sheet is solved exactly, or to `within`, a part of the force.
    """

    def __init__(
        self, scene: Scene, geometry: HandGeometry, now: Callable[[], float], seed: int, within: float | None = None
    ) -> None:
        self.scene = scene
        self.geometry = geometry
        self.now = now
        self.seed = seed if scene.seed is None else scene.seed
        self.world = World(scene, Membrane(geometry.gauge, geometry.width, geometry.thickness), self.seed, within)
        self.robot = self.world.effects.of(RobotEffect)  # type: ignore[type-abstract]
        self.hand: Track[Placed] = Track(Placed.at(_HOME))
        self.fingers: Track[float] = Track(geometry.rest_opening)

    def place(self, home: Pose) -> None:
        """Put the hand where the arm is when it is opened; raises InvalidInput where that is deeper in the object than any press goes."""
        buried = self.world.buried(home, 0.0)
        if buried > _DEEPEST:
            object_, height, top = (
                self.scene.object.type,
                *(f"{1e3 * z:.4g} mm" for z in (home.height, home.height + buried)),
            )
            message = f"the {object_} reaches {top} above the table, and the hand begins at {height}, inside it"
            raise InvalidInput(f"{message}; let the arm of the cell begin higher (height: ...), or move the object")
        self.hand = Track(Placed.at(home))

    def follow_arm(self, pose: Callable[[], Reading[Pose]]) -> None:
        """Let the hand be where an arm that is not simulated says."""

        def placed() -> Reading[Placed]:
            reading = pose()
            return Reading(Placed.at(reading.value), reading.device_time, reading.host_time, reading.sequence)

        self.hand = Reported(placed, Placed.between, self.now)

    def follow_gripper(self, opening: Callable[[], Reading[float]]) -> None:
        """Let the fingers be where a gripper that is not simulated says."""
        self.fingers = Reported(opening, lambda one, other, part: one + part * (other - one), self.now)

    def move_hand(self, path: Callable[[float], Placed], profile: Profile, corners: Sequence[float] = ()) -> float:
        """Start a motion of the hand now, along a path that turns sharply at some distances, m, and return when it will end, s."""
        self.remember()
        return self.hand.begin(self.now(), path, profile, corners)

    def move_fingers(self, path: Callable[[float], float], profile: Profile) -> float:
        """Start a motion of the fingers now, and return when it will end, s."""
        self.remember()
        return self.fingers.begin(self.now(), path, profile)

    def exchange(self, spec: ObjectSpec) -> None:
        """Put another object in the place of the present one; raises InvalidInput where the scene has no answer to it."""
        self.remember()
        self.world.exchange(spec)
        self.scene = self.world.scene

    def force_noises(self) -> dict[str, float]:
        """Return the standard deviation of the force, N an axis, of the kinds of devices whose noise is on, or that the scene switches off.

        A device that makes noise of its own keeps it where the scene leaves the choice to the advisor, and nothing is on.
        """
        found = {}
        for name, effect in registry().items():
            if issubclass(effect, RobotEffect) and effect.noisy is not None:
                on = self.world.effects.get(name)
                if isinstance(on, RobotEffect):
                    found[effect.noisy] = on.force_sd(effect.noisy)
                elif self.scene.choice(name) == "off":
                    found[effect.noisy] = 0.0
        return found

    def remember(self) -> None:
        """Take everything with a memory to where hand and fingers are now, before they are sent elsewhere."""
        if self.world.memory is not None:
            with suppress(NoEquilibrium):  # the next look raises it
                self.contact(self.now())
            with suppress(NoEquilibrium):
                self.world.advance(self.hand.at(self.now()).true, self.stretch(self.now()), self.now())

    def stretch(self, time: float) -> float:
        """Return the stretch of the membrane at a time, m."""
        return self.geometry.stretch(self.fingers.at(time))

    def contact(self, time: float) -> Contact:
        """Return how membrane and object stand at a time, s, up to a second ago.

        Raises
        ------
        NoEquilibrium
            They have no equilibrium there.
        """
        memory = self.world.memory
        if memory is not None:
            for knot in self._knots(self.world.latest, time, memory):
                with suppress(NoEquilibrium):  # on the way, which leaves the memory as it was
                    self.world.advance(self.hand.at(knot).true, self.stretch(knot), knot)
        return self.world.contact(self.hand.at(time).true, self.stretch(time), time)

    def wrench(self, device: str, time: float) -> Wrench:
        """Return the contact wrench that a kind of device reads at a time, s, without its noise."""
        return Wrench(self.contact(time - self.delay(device)).force)

    def shot(self, time: float, number: int) -> Shot:
        """Return what a camera exposes at a time, s, for the frame of this number."""
        seen = time - self.delay("DepthCamera")
        return Shot(time, number, self.hand.at(seen).true, self.stretch(seen), self.contact(seen))

    def delay(self, device: str) -> float:
        """Return the delay of the readings of a kind of device, s."""
        return sum(effect.delay(device) for effect in self.robot)

    def truth(self) -> dict[str, float]:
        """Return what a perfect observer would report now, SI."""
        now = self.now()
        self.contact(now)
        return self.world.truth(self.hand.at(now).true, self.stretch(now), now)

    def random(self, source: str, number: int) -> np.random.Generator:
        """Return the noise source of one sample of what has this name; the same for the same seed, whatever was asked before.

        A negative number stands for what is the same in all samples of a run.
        """
        return noise_source(self.seed, source, number)

    def _knots(self, last: float, time: float, longest: float) -> list[float]:
        """Return the moments in (last, time] at which the path turns sharply, and those of a grid that follows what lies between."""
        turns = {*self.hand.turns(last, time), *self.fingers.turns(last, time)}
        if not math.isfinite(last):
            turns.add(min(time, 0.0))
            last = min(time, 0.0)
        step = longest if math.isfinite(longest) else _STRIDE
        first, end = math.floor(last / step) + 1, math.floor(time / step + 1e-9)
        turns.update(k * step for k in range(first, end + 1))
        return sorted(t for t in turns if t <= time)
