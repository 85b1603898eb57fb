"""The process of the twin behind stand-ins: it solves what hand and object do to each other as the hand goes.

It solves once for each frame of the camera at most, and takes no more than a part of a core for that: further solutions are left
out, and the stand-ins go on with the latest solution.
"""

from __future__ import annotations

import os
import select
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from queue import Queue
from typing import NoReturn

from stretch_bt.errors import NoEquilibrium, StretchError
from stretch_bt.frames import Pose
from stretch_bt.hardware.channel import Channel, ChannelClosed
from stretch_bt.hardware.emulators.height_error import HeightError
from stretch_bt.hardware.emulators.messages import (
    SCENE,
    TWIN,
    Brake,
    Done,
    FeltForce,
    Fingers,
    HandAt,
    LatestFrame,
    Noise,
    Ready,
    Renew,
    Solve,
    TwinRefused,
)
from stretch_bt.hardware.emulators.pictures import Pictures
from stretch_bt.hardware.emulators.setting import Setting
from stretch_bt.hardware.emulators.stand_in_world import begin_fingers, brake_fingers
from stretch_bt.hardware.emulators.twin_camera import lens
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.messages import Message
from stretch_bt.hardware.priority import raise_priority
from stretch_bt.hardware.simulated.placed import Placed
from stretch_bt.hardware.simulated.trace import Trace
from stretch_bt.hardware.simulated.twin import Twin
from stretch_bt.simulation.camera.sensor import Sensor
from stretch_bt.simulation.scene import load_scene

__all__ = ["main"]

#: frames a second, as the camera's
RATE = 30
#: how long after the time of a frame arm and gripper have said where they were then, s
_NEWS = 0.01
#: part of a core that solving takes in the long run, the stand-ins have the rest of a half; and what it may take at once, s
_SHARE, _AT_ONCE = 0.28, 1.0
#: how often an object that creeps is solved while nothing moves, s
_CREEPING = 0.1
#: a move of the hand below this, m, is no motion: an arm at rest still comes nearer to its last setpoint
_STILL = 2e-6
#: nothing is written down of a hand that stands, s
_GAP = 0.05
#: steps of the hand aside and of its turn, m and rad: one that goes down straight does not quite, and each new place is solved from nothing
_GRID = 1e-5
_FEELING = ("Arm", "ForceSensor")
#: how far the force may be off, as a part, where the scene has no tolerance of it, and the shape is within 0.05 mm
_WITHIN = 0.03
#: steps in which a press is rehearsed before it touches and then, m, and how many of those touch
_COARSE, _FINE, _TOUCHES = 1e-3, 1e-4, 13


class StandInLink:
    """The way to one stand-in: its reports of hand or fingers go into the twin; it is sent what it senses."""

    def __init__(self, channel: Channel, senses: list[str]) -> None:
        self.channel, self.senses = channel, senses

    def send(self, message: Message) -> None:
        """Send a message; whoever began a stand-in notices when it is gone."""
        with suppress(ChannelClosed):
            self.channel.send(message)


class Solver:
    """Solves a twin for each frame, and sends the results to the stand-ins.

    Parameters
    ----------
    setting
        Setting of the scene.
    links
        Links to the stand-ins.
    pictures
        Descriptor of the memory that the camera reads.
    """

    def __init__(self, setting: Setting, links: list[StandInLink], pictures: int) -> None:
        scene, geometry = load_scene(setting.scene), HandGeometry()
        self._setting, self._links = setting, links
        exact = {"force", "stiffness"} & scene.tolerance.named().keys()
        self.twin = twin = Twin(scene, geometry, setting.now, setting.seed, None if exact else _WITHIN)
        self._place: tuple[object, ...] | None = None
        self._rehearsal: Iterator[None] = iter(())
        self._rehearse(0.0)
        for _ in self._rehearsal:
            pass
        view = lens(geometry)
        self._sensor = Sensor(twin.world, view, geometry.plane_distance, RATE, twin.random)
        self._pictures = Pictures(pictures, (view.height, view.width))
        self._solved: tuple[Placed, float, float] | None = None
        self._touches = False
        self._frame = self._picture = 0
        self._budget, self._counted = _AT_ONCE, time.monotonic()
        self._renewals: Queue[Callable[[Message], None]] = Queue()

    def renew(self, answer: Callable[[Message], None]) -> None:
        """Put a new object in the place of the present one before the next frame, and answer then; may be called from any thread."""
        self._renewals.put(answer)

    def run(self) -> NoReturn:
        """Solve for ever."""
        self._say("felt", Noise(self.twin.force_noises()))
        number = int(self._setting.now() * RATE)
        while True:
            number = max(number + 1, int(self._setting.now() * RATE))
            time.sleep(max(number / RATE + _NEWS - self._setting.now(), 0.0))
            answer = None if self._renewals.empty() else self._renewals.get()
            said = None if answer is None else self._renew()
            self._go_on(number)
            if answer is not None and said is not None:
                answer(said)

    def _go_on(self, number: int) -> None:
        """Bring the stand-ins to the time of a frame."""
        at, began = number / RATE, time.thread_time()
        if not self._changed(at):
            self._frame = number
            if not self._touches:
                self._rehearse(at)
                next(self._rehearsal, None)
        elif self._may_solve() or self._stands(at):
            with suppress(NoEquilibrium):  # a membrane without an equilibrium is neither felt nor seen
                self._solve(number)
            self._frame = number
        self._budget -= time.thread_time() - began
        self._say("seen", LatestFrame(self._frame, self._picture))

    def _renew(self) -> Message:
        if self._touches:
            return TwinRefused("the hand touches the object; raise it first")
        self.twin.exchange(self.twin.scene.object)
        self._solved = self._place = None
        return Done()

    def _may_solve(self) -> bool:
        """Return whether there is CPU time left for it."""
        now = time.monotonic()
        self._budget = min(self._budget + _SHARE * (now - self._counted), _AT_ONCE)
        self._counted = now
        return self._budget > 0

    def _stands(self, at: float) -> bool:
        """Return whether hand and fingers came to rest, which is solved whatever it costs: readings are taken there."""
        before = at - 1 / RATE
        return self.twin.hand.at(at) == self.twin.hand.at(before) and self.twin.stretch(at) == self.twin.stretch(before)

    def _changed(self, at: float) -> bool:
        """Return whether there is something to solve that was not solved yet."""
        if self._solved is None:
            return True
        twin, (hand, stretch, last) = self.twin, self._solved
        if not twin.world.specimen.timeless and at - last >= _CREEPING:
            return True
        return abs(twin.stretch(at) - stretch) > _STILL or twin.hand.at(at) != hand

    def _solve(self, number: int) -> None:
        twin, at = self.twin, number / RATE
        self._solved = twin.hand.at(at), twin.stretch(at), at
        self._touches = twin.contact(at).place is not None
        self._say("felt", FeltForce({kind: list(twin.wrench(kind, at).force) for kind in _FEELING}))
        self._picture = self._pictures.put(self._sensor.clean(twin.shot(at, number)))

    def _rehearse(self, at: float) -> None:
        """Begin to press below the hand, as nobody sees it, where that was not done yet.

        What is loaded, compiled or built for a first touch then keeps no robot waiting later.
        """
        hand, stretch = self.twin.hand.at(at).true, self.twin.stretch(at)
        place = (hand.position[:2], hand.rotation, stretch)
        if place != self._place:
            self._place, self._rehearsal = place, self._pressed(hand, stretch, at)

    def _pressed(self, hand: Pose, stretch: float, at: float) -> Iterator[None]:
        """Solve presses from a pose down to a little past first contact, one each time that it is asked."""
        touched, step, height = 0, _COARSE, hand.height
        with suppress(NoEquilibrium):
            while height > step and touched < _TOUCHES:
                felt = self.twin.world.contact(hand.at_height(height - step), stretch, at).force[2] > 0
                if felt and step == _COARSE:
                    step = _FINE  # the lightest touch is the dearest
                    continue
                touched += felt
                height -= step
                if felt:
                    yield

    def _say(self, sense: str, message: Message) -> None:
        for link in self._links:
            if sense in link.senses:
                link.send(message)


def listen(twin: Twin, links: list[StandInLink]) -> None:
    """Take the stand-ins' reports of hand and fingers, until no stand-in is left."""
    left, error = {link.channel: link for link in links}, HeightError(twin)
    while left:
        for channel in select.select(list(left), [], [])[0]:
            try:
                for message in channel.drain():
                    take(twin, error, message)
            except ChannelClosed:
                del left[channel]


def take(twin: Twin, error: HeightError, message: Message) -> None:
    """Write down one thing that a stand-in says."""
    match message:
        case HandAt(at, six):
            before = twin.hand.at(at).told
            told = steadied(before, six)
            if not isinstance(twin.hand, Trace):
                twin.hand = Trace(Placed.at(told), Placed.between, _GAP)
            if told != before:
                twin.hand.note(at, Placed(told, error.true(at, told)))
        case Fingers(at, to, speed):
            begin_fingers(twin.fingers, at, to, speed)
        case Brake(at):
            brake_fingers(twin.fingers, at)


def steadied(before: Pose, six: list[float]) -> Pose:
    """Return a pose of position, m, and rotation vector, rad, on a grid but for its height; a coordinate that hardly moved stays as before."""
    x, y, z, *turn = six
    aside = [
        _kept(new, old, _GRID) for new, old in zip((x, y, *turn), (*before.position[:2], *before.rotation), strict=True)
    ]
    height = z if abs(z - before.height) > _STILL else before.height
    return Pose((aside[0], aside[1], height), (aside[2], aside[3], aside[4]))


def _kept(new: float, old: float, step: float) -> float:
    """Return the multiple of a step next to a new value; the old one as long as the new one is within three quarters of a step."""
    return old if abs(new - old) < 0.75 * step else round(new / step) * step


def main(control: int, pictures: int, *wires: int) -> NoReturn:
    """Solve for the stand-ins at the other ends of some sockets until whoever began this is gone."""
    began = Channel(socket.socket(fileno=control), TWIN)
    raise_priority()  # it takes no more than its part of a core, and what it shows must not be old
    (first,) = began.first()
    assert isinstance(first, Solve)
    links = [
        StandInLink(Channel(socket.socket(fileno=wire), SCENE), senses)
        for wire, senses in zip(wires, first.senses, strict=True)
    ]
    try:
        solver = Solver(first.setting, links, pictures)
    except StretchError as error:
        began.send(TwinRefused(str(error)))
        sys.exit(1)
    began.send(Ready())
    threading.Thread(target=listen, args=(solver.twin, links), daemon=True).start()
    threading.Thread(target=serve, args=(began, solver), daemon=True).start()
    solver.run()


def serve(began: Channel, solver: Solver) -> None:
    """Do what the other side of a channel asks, and end this process when it says so, or is gone."""
    with suppress(ChannelClosed):
        while all(isinstance(asked, Renew) for asked in began.first()):
            solver.renew(began.send)
    os._exit(0)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
