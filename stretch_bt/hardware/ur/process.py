"""The process that has the clients of ur_rtde: a crash, a hang or a reconnect of theirs ends it, and nothing else.

It reads the arm in every cycle, checks the limits, leads the hand along its path, and feeds the controller's watchdog. It brakes when
the run falls silent and ends when the run is gone; one that hangs is ended by its own alarm.
"""

from __future__ import annotations

import math
import os
import signal
import socket
import sys
import threading
import time
from contextlib import suppress
from typing import NoReturn

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.hardware.channel import Channel, ChannelClosed, Message
from stretch_bt.hardware.interfaces import UNWATCHED, MotionState
from stretch_bt.hardware.priority import raise_priority
from stretch_bt.hardware.transforms import Array, inverse, pose_of, six, transform, transform_of
from stretch_bt.hardware.ur.guard import beyond, plausible, safety_stop
from stretch_bt.hardware.ur.kinematics import MODELS
from stretch_bt.hardware.ur.ride import Ride
from stretch_bt.hardware.ur.session import Refused, Session
from stretch_bt.hardware.ur.settings import ArmState, Settings

__all__ = ["main"]

#: how long one cycle, connecting, and making ready may take before the process is ended, s
_STUCK, _CONNECTING, _ENGAGING = 2.0, 4.0, 10.0
#: a cycle that is later than this, s, was not given its time by the machine
_LATE = 0.05
#: how many cycles a setpoint may be ahead of the one before
_LEAP = 3
#: how long the control script may refuse commands, s
_DEAF = 0.1


class _Keeper:
    """Keeps one arm."""

    def __init__(self, channel: Channel, settings: Settings, messages: list[Message]) -> None:
        self._channel, self._settings, self._waiting = channel, settings, messages
        self._base, self._into_base = transform(settings.base), inverse(transform(settings.base))
        self._mount, self._correction = transform(settings.hand), np.eye(4)
        self._zero = np.zeros(6)
        self._session = Session(settings)
        self._beat = self._new = self._watched = time.monotonic()
        self._stamp = -math.inf
        self._number = 0
        self._contact_height: float | None = None
        self._ride: Ride | None = None
        self._taken = 0.0
        self._touched: float | None = None
        self._motion, self._motion_state = 0, "done"
        self._fault: str | None = None
        self._engaged = self._guarded = False
        self._braking: threading.Thread | None = None

    def run(self) -> None:
        """Go on until the other side is gone."""
        due = woke = time.monotonic()
        while True:
            signal.setitimer(signal.ITIMER_REAL, _STUCK)
            woke, late = time.monotonic(), time.monotonic() - woke - 1 / self._settings.rate
            if late > _LATE:  # this process did not run: nobody was silent towards it
                self._new += late
                self._beat += late
                self._watched += late
            self._listen()
            if self._read():
                self._look()
                self._channel.send(self._state().to_message())
            else:
                self._channel.send({"say": "alive"})
            if self._engaged and self._ride is None and not self._is_braking():
                self._session.kick()
            due = max(due + 1 / self._settings.rate, time.monotonic() - 0.05)
            time.sleep(max(due - time.monotonic(), 0.0))

    def end(self) -> None:
        """Brake, and end the control script."""
        signal.setitimer(signal.ITIMER_REAL, _STUCK)
        if self._ride is not None:
            self._session.brake()
        if self._braking is not None:
            self._braking.join()
        self._session.leave()

    # --- what is asked

    def _listen(self) -> None:
        """Do what is asked, in its order; while the arm brakes, it waits."""
        came = self._channel.drain()
        if came:
            self._beat = time.monotonic()
        self._waiting += came
        while self._waiting:
            if self._is_braking():
                return
            self._obey(self._waiting.pop(0))

    def _is_braking(self) -> bool:
        return self._braking is not None and self._braking.is_alive()

    def _obey(self, message: Message) -> None:
        match message.get("do"):
            case "beat":
                self._contact_height = message["contact_height"]
                self._watched = max(self._watched, message["watched"])
            case "engage":
                self._engage(message)
            case "zero":
                self._zero = np.array(message["wrench"])
            case "guard":
                self._guard(message["number"])
            case "follow":
                self._follow(message)
            case "stop":
                self._stop(MotionState.STOPPED)
                self._waiting.insert(0, {"do": "say stopped", "number": message["number"]})
            case "say stopped":  # when the arm stands
                self._channel.send({"say": "stopped", "number": message["number"]})
            case "end":
                raise ChannelClosed("told to end")

    def _engage(self, message: Message) -> None:
        if self._ride is not None:
            self._stop(MotionState.STOPPED)
            self._waiting.insert(0, message)
            return
        signal.setitimer(signal.ITIMER_REAL, _ENGAGING)
        reason = None
        try:
            self._session.engage(again=message["again"], unlock=message["unlock"])
        except Refused as refused:
            reason = str(refused)
        self._engaged, self._guarded = reason is None, False
        self._fault = reason and safety_stop(self._session.receive.getSafetyStatusBits())
        self._beat = time.monotonic()
        self._channel.send({"say": "engaged", "number": message["number"], "reason": reason})

    def _guard(self, number: int) -> None:
        """Hold the limits from now on, and tell what is past one, or wrong, already."""
        self._guarded = self._engaged
        if self._guarded and (reason := self._passed()) is not None:
            self._fail(reason)
        self._channel.send({"say": "guarded", "number": number, "reason": self._fault})

    def _follow(self, message: Message) -> None:
        if self._ride is not None:
            self._stop(MotionState.PREEMPTED)
            self._waiting.insert(0, message)
            return
        self._motion, self._motion_state = message["number"], "moving"
        if not self._engaged or self._fault is not None:
            self._motion_state = "stopped"
            return
        poses = [Pose(tuple(six[:3]), tuple(six[3:])) for six in message["path"]]
        s = self._settings
        self._ride = Ride([self._place(), *poses], message["speed"], s.acceleration, s.tolerance)
        self._taken = self._watched = time.monotonic()
        self._touched = self._force()

    def _stop(self, state: MotionState) -> None:
        """Begin to brake, in a thread because the client waits until the arm stands."""
        if self._ride is not None:
            self._ride, self._motion_state = None, str(state)
            self._braking = threading.Thread(target=self._session.brake, daemon=True)
            self._braking.start()

    # --- what is seen

    def _read(self) -> bool:
        """Return whether there is a new state; ends the process when none comes."""
        receive, now = self._session.receive, time.monotonic()
        if not receive.isConnected():
            raise OSError("the controller closed the connection")
        stamp = receive.getTimestamp()
        if stamp != self._stamp:
            if not plausible(receive):
                raise OSError("what the controller sends is broken")
            self._stamp, self._new = stamp, now
            return True
        if now - self._new > self._settings.lost_after:
            raise OSError(f"nothing new came from the controller for {now - self._new:.2g} s")
        return False

    def _look(self) -> None:
        """Check what must hold, and lead the hand on."""
        reason = safety_stop(self._session.receive.getSafetyStatusBits())
        if reason is None and self._engaged and not self._session.program_runs:
            reason = "the control script ended: it was stopped at the pendant, by its watchdog or by an error; acknowledge to run it again"
        if reason is None and self._ride is not None:
            reason = self._neglected()
        if reason is None and self._guarded:
            reason = self._passed()
        if reason is not None:
            self._fail(reason)
        elif self._ride is not None:
            self._lead(self._ride)

    def _neglected(self) -> str | None:
        """Return that the run is silent, or hangs."""
        now = time.monotonic()
        if (silent := now - self._beat) > self._settings.heartbeat:
            return f"the run gave no sign of life for {silent:.2g} s"
        if (unwatched := now - self._watched) > self._settings.unwatched:
            return UNWATCHED.format(unwatched)
        return None

    def _passed(self) -> str | None:
        """Return which limit is passed, by an arm that moves or stands."""
        speed = math.hypot(*self._session.receive.getActualTCPSpeed()[:3])
        past = beyond(self._settings, self._place().position, speed, self._force(), self._contact_height)
        return (
            past and f"{past}; see why, move the hand back at the pendant where it is still past it, then acknowledge"
        )

    def _lead(self, ride: Ride) -> None:
        since = ride.since(time.monotonic(), _LEAP / self._settings.rate)
        contact = self._settings.contact_force
        if contact is not None and self._touched is not None and self._force() - self._touched > contact:
            self._stop(MotionState.BLOCKED)
            return
        judged = ride.judge(since, self._place())
        if isinstance(judged, MotionState):
            if judged is not MotionState.MOVING:
                self._stop(judged)
            elif self._session.servo(six(self._into_base @ transform_of(ride.setpoint(since)))):
                self._taken = time.monotonic()
            elif time.monotonic() - self._taken > _DEAF:  # a stop is seen by then, and tells more
                self._fail("the control script takes no commands; acknowledge to run it again")
        else:
            self._fail(judged)

    def _fail(self, reason: str) -> None:
        """Keep the first fault until it is acknowledged; whatever moves comes to rest."""
        self._stop(MotionState.STOPPED)
        self._engaged = self._guarded = False
        self._fault = self._fault or reason

    def _place(self) -> Pose:
        return pose_of(self._base @ self._hand())

    def _hand(self) -> Array:
        """Return the hand in the base: as the controller has it while its tool is known to be the hand, else by joint angles.

        What the controller's tool is before and after the control script is not known from here. Nominal kinematics are off by
        millimetres, which the difference while it was known takes away.
        """
        receive = self._session.receive
        nominal = MODELS[self._settings.model].forward(receive.getActualQ()) @ self._mount
        if not self._engaged:
            return nominal @ self._correction
        told = transform(receive.getActualTCPPose())
        self._correction = inverse(nominal) @ told
        return told

    def _force(self) -> float:
        wrench = np.subtract(self._session.receive.getActualTCPForce(), self._zero)
        return float(np.linalg.norm(wrench[:3]))

    def _state(self) -> ArmState:
        receive = self._session.receive
        self._number += 1
        return ArmState(
            time=self._stamp,
            number=self._number,
            q=tuple(receive.getActualQ()),
            pose=tuple(six(self._hand())),
            speed=tuple(receive.getActualTCPSpeed()),
            wrench=tuple(np.subtract(receive.getActualTCPForce(), self._zero).tolist()),
            motion=self._motion,
            motion_state=self._motion_state,
            fault=self._fault,
            engaged=self._engaged,
        )


def main(descriptor: int) -> NoReturn:
    """Keep an arm for the process at the other end of a socket; ends without the clients' destructors, which may hang or abort."""
    channel = Channel(socket.socket(fileno=descriptor))
    keeper = None
    raise_priority()  # it does little, and what it watches does not wait
    try:
        signal.setitimer(signal.ITIMER_REAL, _CONNECTING)
        first, *others = channel.first()
        keeper = _Keeper(channel, Settings.from_message(first), others)
        keeper.run()
    except ChannelClosed:
        if keeper is not None:
            with suppress(Exception):
                keeper.end()
    except BaseException as error:
        with suppress(ChannelClosed):
            channel.send(
                {"say": "lost", "reason": str(error) or type(error).__name__, "missing": isinstance(error, ImportError)}
            )
    finally:
        sys.stderr.flush()
        os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]))
