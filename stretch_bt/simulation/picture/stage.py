"""A scene at the two moments that its picture shows: at first touch, and pressed as deep as it says."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import DepthFrame, Intrinsics, Pose
from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.sensor import Sensor, Shot, window
from stretch_bt.simulation.camera.skin import RoundBump, Skin
from stretch_bt.simulation.fidelity.make import Membrane
from stretch_bt.simulation.noise_source import noise_source
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.world import Contact, World

__all__ = ["Moment", "Stage", "act"]

_CLEAR = 1e-4  # m above first touch, where the way down begins
_SPEED = 0.005  # m/s, where a scene says that the hand stands still


@dataclass(frozen=True, slots=True)
class Stage:
    """A picture's part of the cell: the membrane, how far the camera is from it, m, the part of the image that it sends, frames
    a second, the camera's name, which its noise goes by, and the seed where the scene has none.
    """

    membrane: Membrane = field(default_factory=Membrane)
    plane_distance: float = 0.200
    lens: Intrinsics = field(default_factory=lambda: window(0.090, 0.180, 0.200))
    rate: float = 30.0
    camera: str = "camera"
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Moment:
    """How hand and object stand: the free membrane's shape at `touch`, and the pressed one's at `pose`; the frame is of the latter.

    `refusal` says why nothing is pressed; then `pose` and the rest belong to the touch, and where not even the free membrane has
    an equilibrium there is no frame.
    """

    world: World
    touch: Pose
    free: Skin
    pose: Pose
    contact: Contact
    skin: Skin
    frame: DepthFrame | None
    refusal: str = ""

    @property
    def scene(self) -> Scene:
        """Its scene."""
        return self.world.scene


def act(scene: Scene, stage: Stage) -> Moment:
    """Press the middle of a scene's object, at the stretch, depth and speed of its conditions."""
    world = World(scene, stage.membrane, seed=stage.seed if scene.seed is None else scene.seed)
    stretch = scene.conditions.stretch
    over = Pose((scene.object.position.x, scene.object.position.y, scene.object.top))
    nothing = Contact(0.0, 0.0, (0.0, 0.0, 0.0))
    flat: Skin = RoundBump(None, (0.0, 0.0), stage.membrane.width, stage.membrane.gauge + stretch)
    try:
        free, touch = world.fidelity.free(stretch), over.moved(z=world.lift(over, stretch))
    except NoEquilibrium as error:
        return Moment(world, over, flat, over, nothing, flat, None, error.reason)
    try:
        pressed = over.moved(z=-min(scene.conditions.depth, over.height))  # the arm stops at the table
        time = _press(world, touch, pressed, stretch)
        contact = world.contact(pressed, stretch, time)
        skin = world.skin(contact, stretch)
    except NoEquilibrium as error:
        frame = _frame(world, stage, Shot(0.0, 0, touch, stretch, nothing))
        return Moment(world, touch, free, touch, nothing, free, frame, error.reason)
    frame = _frame(world, stage, Shot(time, int(time * stage.rate), pressed, stretch, contact))
    return Moment(world, touch, free, pressed, contact, skin, frame)


def _press(world: World, touch: Pose, pressed: Pose, stretch: float) -> float:
    """Take the memory of object and membrane along the way down, and return when the hand arrives, s."""
    above = touch.moved(z=_CLEAR)
    way = above.height - pressed.height
    duration = way / (world.scene.conditions.speed or _SPEED)
    longest = world.memory
    steps = math.ceil(duration / longest) if longest is not None and math.isfinite(longest) else 1
    for k in range(steps + 1):
        world.advance(above.moved(z=-way * k / steps), stretch, duration * k / steps)
    return duration


def _frame(world: World, stage: Stage, shot: Shot) -> DepthFrame:
    seed = stage.seed if world.scene.seed is None else world.scene.seed

    def random(effect: str, number: int) -> np.random.Generator:
        return noise_source(seed, f"{stage.camera} {effect}", number)

    sensor = Sensor(world, stage.lens, stage.plane_distance, stage.rate, random)
    exposure = sensor.expose(shot)
    place = (stage.plane_distance, shot.pose.height, shot.stretch, shot.pose)
    return DepthFrame(counts(exposure), exposure.unit, stage.lens, shot.time, shot.number, *place)
