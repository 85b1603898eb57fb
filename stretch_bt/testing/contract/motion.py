"""Clauses for a device that moves."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar, NoReturn

import pytest

from stretch_bt.errors import StretchError
from stretch_bt.hardware.interfaces import Motion, MotionState
from stretch_bt.testing.contract.readings import ReadingClauses
from stretch_bt.testing.contract.trial import distance, fault, shown

__all__ = ["MotionClauses"]

#: how long a command may keep a tick waiting, s; a device may need as long to begin and to brake
_COMMAND, _BEGINNING, _BRAKING = 0.3, 0.3, 0.3
#: how many times longer the rest of a way lasts than the device may go on after a stop; the slowest motion for that, m/s
_SEEN, _CREEP = 1.2, 0.002
#: shortest duration of a way from which a speed is judged, s
_JUDGED = 0.5
_TRIES = 3
#: least and greatest part of the time that the way takes at the speed
_FASTEST, _SLOWEST = 0.75, 2.0


@dataclass
class _Course:
    """A motion as it was seen: time, s, and place at each look, and when it ended."""

    states: list[tuple[float, Any]] = field(default_factory=list)
    state: MotionState = MotionState.MOVING
    ended: float = 0.0


class MotionClauses(ReadingClauses):
    """Clauses on motions between the two places that the test named."""

    needs: ClassVar[tuple[str, ...]] = ("moves",)

    def test_opening_moves_nothing(self) -> None:
        """A person may have a hand in the cell when a run begins: opening reads, and the first motion is a command's."""
        trial = self.trial
        device = trial.open()
        trial.go(device, trial.moves[0])
        trial.wait(0.2 + self.contract.latency)
        before = trial.place(device)
        device.close()
        trial.wait(0.1)
        device.open()
        for passed in trial.ticks(0.5 + self.contract.latency):
            if (way := distance(trial.place(device), before)) > self.contract.tolerance:
                fault(
                    f"opening moves the device: it was closed at {shown(before)} and is {1e3 * way:.1f} mm from there {passed:.2f} s "
                    "after it was opened again; open() must not command a motion"
                )

    def test_commands_return_at_once(self) -> None:
        """The tick that sends a command also holds the guards: while a command waits for the end of its motion, nothing is guarded."""
        device, home = self._at_home()
        longest = min(_COMMAND, 0.5 * distance(home, self._target) / self.trial.speed)
        for left in reversed(range(_TRIES)):  # a machine that is busy may be late once
            begun = time.monotonic()
            motion = self._begin(device)
            took = time.monotonic() - begun
            if self.trial.virtual is not None or took <= longest:
                break
            if not left:
                fault(
                    f"a command took {took:.2f} s, at most {longest:.2g} s allowed: "
                    "begin the motion, and report its state in the function that is returned"
                )
            self.trial.go(device, home)
        if (state := motion.poll()) is not MotionState.MOVING:
            fault(
                f"a motion of {shown(self._target)} is {state} as soon as it was commanded: DONE is for fingers or a hand that arrived"
            )

    def test_motions_arrive_in_their_time(self) -> None:
        """A node goes on when the motion is DONE, and counts on the speed: DONE elsewhere, or a faster motion, presses where nobody expects it."""
        device, home = self._at_home()
        way = distance(home, self._target)
        asked = min(self.trial.speed, way / _JUDGED)
        course = self._follow(device, self._begin(device, asked), asked)
        least = _FASTEST * (way - 2 * self.contract.tolerance) / asked
        speed = f"{1e3 * asked:.0f} mm/s"
        if course.state is not MotionState.DONE:
            self._ended_before(device, course)
        here = course.states[-1][1]
        settled = self._settle(device)
        if distance(settled, self._target) > self.contract.tolerance:
            fault(
                f"the motion was DONE, but the device stands at {shown(settled)}, {1e3 * distance(settled, self._target):.1f} mm from its "
                f"target {shown(self._target)}; at most {1e3 * self.contract.tolerance:.1f} mm allowed"
            )
        if course.ended < least:
            why = "the speed is not sent, or in another unit"
            if distance(here, settled) > self.contract.tolerance:
                why = "DONE is reported before it arrived"
            fault(
                f"a way of {1e3 * way:.0f} mm was done after {course.ended:.2f} s; at {speed} it takes {way / asked:.2f} s: {why}"
            )
        longest = _SLOWEST * way / asked + _BEGINNING + _BRAKING + self.contract.latency
        if course.ended > longest:
            fault(
                f"a way of {1e3 * way:.0f} mm took {course.ended:.2f} s; at {speed} it takes {way / asked:.2f} s: "
                "the speed is not sent, or DONE is reported late"
            )

    def _ended_before(self, device: Any, course: Any) -> NoReturn:
        """Say of a motion with nothing in the way that it ended otherwise than DONE, and whether the device got there all the same."""
        there, settled = course.states[-1][1], self._settle(device)
        what = (
            f"a motion to {shown(self._target)} with nothing in the way ended as {course.state} after {course.ended:.2g} s, "
            f"{1e3 * distance(there, self._target):.1f} mm from its target"
        )
        if distance(settled, self._target) <= self.contract.tolerance:
            fault(f"{what}, which it then reached: the end is reported too early")
        fault(what)

    def test_readings_follow_the_motion(self) -> None:
        """Guards and depths go by readings while it moves: a limit that is read late is passed before anybody stops."""
        device, home = self._at_home()
        course = self._follow(device, self._begin(device))
        tolerance, latency = self.contract.tolerance, self.contract.latency
        begun = next((t for t, place in course.states if distance(place, home) > tolerance), course.ended)
        late = begun - tolerance / self.trial.speed - _BEGINNING
        if late > latency:
            fault(
                f"the readings show a motion {late + _BEGINNING:.2g} s after it was commanded, at most {latency + _BEGINNING:.2g} s allowed: "
                f"they are some {late + _BEGINNING:.1g} s old, with the time of now; give the newest, stamped when it was taken"
            )
        end = next(
            (
                t
                for t in self.trial.ticks(3.0 + latency)
                if distance(self.trial.place(device), self._target) <= tolerance
            ),
            None,
        )
        if end is not None and end > latency:
            fault(
                f"when the motion ended as {course.state}, the reading was {1e3 * distance(course.states[-1][1], self._target):.1f} mm "
                "from the target and came "
                f"there {end:.2g} s later, at most {latency:g} s allowed: that reading is {end:.2g} s old, or the end is reported too early"
            )

    def test_stop_ends_a_motion(self) -> None:
        """Every safe stop, Ctrl-C included, is this call: a device that goes on after it cannot be stopped by any tree."""
        self._stopped(lambda device, motion: motion.stop(), "stop()", "send the stop, and do not wait until it stands")

    def test_closing_ends_a_motion(self) -> None:
        """A run that breaks off closes its devices: nothing may go on that nobody watches any more."""

        def close(device: Any, motion: Motion) -> None:
            device.close()
            device.open()

        self._stopped(close, "close()")

    def test_a_new_command_replaces_the_motion(self) -> None:
        """Control belongs to the newest command; a device that finishes the old one first moves against the tree."""
        device, home = self._at_home()
        lasting = _BEGINNING + _BRAKING + self.contract.latency
        speed = self._seen(home, lasting)
        old = self._begin(device, speed)
        self._underway(device, home, old)
        turned = self.trial.place(device)
        new = self.trial.move(device, home, speed, owner="second")
        course = self._follow(device, new, speed)
        if old.poll() is not MotionState.PREEMPTED:
            fault(f"the motion that was replaced is {old.poll()}, not preempted")
        if distance(self._settle(device), home) > self.contract.tolerance:
            fault(
                f"a command during a motion was not followed: the device stands at {shown(self.trial.place(device))}, not at {shown(home)}"
            )
        farthest = max(distance(place, home) for _, place in course.states) - distance(turned, home)
        allowed = speed * lasting + self.contract.tolerance
        if farthest > allowed:
            fault(
                f"the device went on by {1e3 * farthest:.0f} mm after a new command, at most {1e3 * allowed:.0f} mm allowed: "
                "it finishes the old motion first"
            )

    @property
    def _target(self) -> Any:
        return self.trial.moves[1]

    def _at_home(self) -> tuple[Any, Any]:
        """Return the device, opened and standing at the first place."""
        device = self.trial.open()
        home = self.trial.moves[0]
        self.trial.go(device, home)
        self._settle(device)
        return device, home

    def _begin(self, device: Any, speed: float | None = None) -> Motion:
        try:
            return self.trial.move(device, self._target, speed)
        except StretchError as error:
            fault(f"a command to {shown(self._target)} is refused: {error}")

    def _follow(self, device: Any, motion: Motion, speed: float | None = None) -> _Course:
        """Watch a motion until it ends."""
        course = _Course()
        for passed in self.trial.ticks(sum(self.trial.patience(device, place, speed) for place in self.trial.moves)):
            course.state = motion.poll()
            course.states.append((passed, self.trial.place(device)))
            course.ended = passed
            if course.state is not MotionState.MOVING:
                break
        else:
            fault(
                f"the motion to {shown(self._target)} is {course.state} for {course.ended:.1f} s: its end is not reported"
            )
        return course

    def _settle(self, device: Any) -> Any:
        """Wait until readings stand still, at most a while, and return the last."""
        before = self.trial.place(device)
        for _ in range(20):
            self.trial.wait(0.1 + self.contract.latency)
            here = self.trial.place(device)
            if distance(before, here) <= 0.1 * self.contract.tolerance:
                return here
            before = here
        return before

    def _underway(self, device: Any, home: Any, motion: Motion) -> None:
        """Wait until a third of the way is gone, and look at the motion meanwhile, as a node does."""
        way = distance(home, self._target)
        for _ in self.trial.ticks(self.trial.patience(device, self._target)):
            if (state := motion.poll()) is not MotionState.MOVING:
                fault(
                    f"a motion to {shown(self._target)} ended as {state} before the readings showed a third of its way"
                )
            if distance(self.trial.place(device), home) > way / 3:
                return
        fault(f"the readings do not move after a command to {shown(self._target)}")

    def _seen(self, home: Any, lasting: float) -> float:
        """Return a speed, m/s, at which a device that goes on for a time, s, after a third of the way is still short of its target.

        Skips the clause where that is slower than a device can be asked for.
        """
        way, tolerance = distance(home, self._target), self.contract.tolerance
        speed = min(self.trial.speed, (2 / 3 * way - tolerance) / (_SEEN * lasting))
        if speed < _CREEP:
            least = 1.5 * (tolerance + _CREEP * _SEEN * lasting)
            pytest.skip(
                f"the places of `moves` are {1e3 * way:.1f} mm apart, too near to see within {1e3 * tolerance:g} mm whether a motion "
                f"ends early; name places at least {math.ceil(1e3 * least)} mm apart"
            )
        return speed

    def _stopped(self, end: Callable[[Any, Motion], None], what: str, quickly: str = "") -> None:
        """End a motion on its way, and look how far it goes on; `quickly` says what to do where ending it takes long."""
        device, home = self._at_home()
        speed = self._seen(home, _BRAKING + self.contract.latency)
        for left in reversed(range(_TRIES)):  # a machine that is busy may be late once
            motion = self._begin(device, speed)
            self._underway(device, home, motion)
            before, begun = self.trial.place(device), time.monotonic()
            end(device, motion)
            took = 0.0 if self.trial.virtual is not None else time.monotonic() - begun
            if took <= _COMMAND or not left:
                break
            self.trial.go(device, home)
        self._stands(device, before, speed * (_BRAKING + self.contract.latency + min(took, _COMMAND)), what)
        if quickly and took > _COMMAND:
            fault(f"{what} took {took:.2f} s, at most {_COMMAND:g} s allowed: {quickly}")
        if motion.poll() is not MotionState.STOPPED:
            fault(f"after {what} the motion is {motion.poll()}, not stopped")
        self.trial.go(device, home)

    def _stands(self, device: Any, before: Any, braking: float, what: str) -> None:
        """Compare where a device stands with where it was as its motion was ended, and the way, m, that it may need to brake."""
        tolerance = self.contract.tolerance
        self.trial.wait(_BRAKING + self.contract.latency)
        here = self.trial.place(device)
        self.trial.wait(0.3)
        there = self.trial.place(device)
        if distance(there, self._target) <= tolerance < distance(before, self._target):
            fault(
                f"after {what} the device went on to its target, {shown(self._target)}: {what} must end the motion on the device"
            )
        if (way := distance(before, there)) > braking + tolerance or distance(here, there) > tolerance:
            fault(
                f"after {what} the device went on by {1e3 * way:.1f} mm, at most {1e3 * (braking + tolerance):.1f} mm allowed: "
                f"{what} must end the motion on the device"
            )
