"""What the process of an arm decides in a cycle: a function of its state, the time and what came in, without clock, client or thread."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import UNWATCHED, MotionState
from stretch_bt.hardware.latched import NEW_RUN
from stretch_bt.hardware.messages import Answer, End, Message
from stretch_bt.hardware.ur.cycle import (
    Brake,
    Command,
    ControlState,
    Feeling,
    GiveUp,
    Inputs,
    Kick,
    Leave,
    MakeReady,
    Say,
    Servo,
)
from stretch_bt.hardware.ur.force_filter import ForceFilter
from stretch_bt.hardware.ur.guard import MeasuredState, beyond, plausible, safety_stop
from stretch_bt.hardware.ur.messages import (
    Alive,
    ArmState,
    Beat,
    ControllerSettings,
    Engage,
    Feel,
    Follow,
    Guard,
    Guarded,
    MeanWrench,
    Six,
    Stop,
    Stopped,
    Zero,
    Zeroed,
)
from stretch_bt.hardware.ur.mounting import Mounting
from stretch_bt.hardware.ur.ride import Ride
from stretch_bt.hardware.ur.standing_force import StandingForce

__all__ = ["Control"]

#: how many cycles a setpoint may be ahead of the one before
_LEAP = 3
#: how long the control script may refuse commands, s: a stop is seen by then, and says more
_DEAF = 0.1


class Control:
    """Decides for one arm.

    Parameters
    ----------
    settings
        What it goes by.
    """

    def __init__(self, settings: ControllerSettings) -> None:
        self.settings = settings
        self.mounting = Mounting(settings)

    def begin(self, now: float) -> ControlState:
        """Return the state before the first cycle, at a time of the monotonic clock, s."""
        over = self.settings.force_filter
        force = ForceFilter(over, round(over * self.settings.rate))
        return ControlState(now, now, now, now, force, StandingForce())

    def step(self, state: ControlState, now: float, inputs: Inputs) -> tuple[ControlState, tuple[Command, ...]]:
        """Return the state after a cycle, and what is to be done, in this order."""
        cycle = _Cycle(self, state, now, inputs)
        cycle.go()
        return cycle.state, tuple(cycle.commands)


class _Cycle:
    """One cycle; its state is replaced as it goes."""

    def __init__(self, control: Control, state: ControlState, now: float, inputs: Inputs) -> None:
        self.settings, self.mounting = control.settings, control.mounting
        self.state, self.now, self.inputs = state, now, inputs
        self.braking = inputs.braking
        self.commands: list[Command] = []

    def go(self) -> None:
        s, late, measured = self.state, self.inputs.late, self.inputs.measured
        self.state = replace(s, heard=s.heard + late, news=s.news + late, watched=s.watched + late)
        if (reason := self._lost()) is not None:
            self.commands.append(GiveUp(reason))
            return
        if measured is not None:
            self._measure(measured)
        self._take_engaged()
        self._listen()
        if measured is not None:
            self._look(measured)
        if measured is None:
            self._say(Alive())
        else:
            self._say(self._told(measured))
            self._say_zeroed()
        if self.state.engaged and self.state.ride is None and not self.braking:
            self.commands.append(Kick())

    def _say(self, message: Message) -> None:
        self.commands.append(Say(message))

    # --- what the controller sends

    def _lost(self) -> str | None:
        """Return why the controller is lost."""
        measured, silent = self.inputs.measured, self.now - self.state.news
        if measured is not None:
            return None if plausible(measured) else "the controller's data are broken"
        return f"nothing new came from the controller for {silent:.2g} s" if silent > self.settings.lost_after else None

    def _measure(self, measured: MeasuredState) -> None:
        """Take what was measured.

        The hand is where the controller has it while its tool is known to be the hand. What its tool is before and after the control
        script is not known: then the hand is by joint angles, with the deviation from nominal kinematics as it was last known.
        """
        s = self.state
        deviation, hand = s.deviation, measured.tool
        if s.engaged:
            deviation = self.mounting.deviation(measured.q, measured.tool)
        else:
            hand = self.mounting.corrected(measured.q, deviation)
        self.state = replace(
            s,
            news=self.now,
            number=s.number + 1,
            measured=measured,
            deviation=deviation,
            hand=hand,
            pose=self.mounting.in_world(hand),
            force=s.force.take(measured.time, measured.wrench),
            standing=s.standing.take(measured.time, measured.wrench, live=s.engaged and self.settings.noisy),
        )
        if s.feeling is not None:
            self._feel(s.feeling, measured)

    def _feel(self, feeling: Feeling, measured: MeasuredState) -> None:
        """Take one more sample, and report the mean of all once the time is over."""
        samples = (*feeling.samples, measured.wrench)
        over = measured.time >= feeling.until
        self.state = replace(self.state, feeling=None if over else replace(feeling, samples=samples))
        if over:
            mean = cast(Six, tuple(np.mean(samples, axis=0).tolist()))
            self._say(MeanWrench(feeling.number, mean, len(samples)))

    # --- what the driver asks

    def _take_engaged(self) -> None:
        engaged, measured = self.inputs.engaged, self.state.measured
        if engaged is None:
            return
        stop = safety_stop(measured.safety_bits) if measured is not None else None
        fault = None if engaged.reason is None else stop
        # what the controller measured before counts from another zero, and another payload
        force = self.state.force.anew()
        self.state = replace(self.state, engaged=engaged.reason is None, fault=fault, heard=self.now, force=force)
        self._say(engaged)

    def _listen(self) -> None:
        """Do what is asked, in its order; while the arm brakes, it waits."""
        came = self.inputs.messages
        heard = self.now if came else self.state.heard
        self.state = replace(self.state, waiting=(*self.state.waiting, *came), heard=heard)
        while self.state.waiting and not self.braking:
            first, *others = self.state.waiting
            self.state = replace(self.state, waiting=tuple(others))
            self._obey(first)

    def _obey(self, message: Message) -> None:
        s = self.state
        match message:
            case Beat(contact_height, watched):
                self.state = replace(s, contact_height=contact_height, watched=max(s.watched, watched))
            case Engage(number):
                self.commands.append(MakeReady(number))
            case Feel(number, over) if s.measured is not None:
                self.state = replace(s, feeling=Feeling(number, s.measured.time + over))
            case Zero(number, wrench):
                self.state = replace(s, zero=wrench, zeroing=number)
            case Guard(number):
                self._guard(number)
            case Follow():
                self._follow(message)
            case Stop(number):
                self._stop(MotionState.STOPPED)
                self._wait(Stopped(number))
            case Answer():  # it had to wait until the arm stands
                self._say(message)
            case End():
                self.commands.append(Leave())

    def _wait(self, message: Message) -> None:
        """Put what is to be done or said once the arm stands before everything else."""
        self.state = replace(self.state, waiting=(message, *self.state.waiting))

    def _guard(self, number: int) -> None:
        """Hold the limits from now on, and report a value that is past one, or another fault, that is there already."""
        self.state = replace(self.state, guarded=self.state.engaged)
        if self.state.guarded and (reason := self._passed()) is not None:
            self._fail(reason)
        self._say(Guarded(number, self.state.fault))

    def _follow(self, message: Follow) -> None:
        if self.state.ride is not None:
            self._stop(MotionState.PREEMPTED)
            self._wait(message)
            return
        s, limits = self.state, self.settings
        ready = s.engaged and s.fault is None
        poses = [s.pose, *(Pose((x, y, z), (a, b, c)) for x, y, z, a, b, c in message.path)]
        ride = Ride.through(poses, message.speed, limits.acceleration, limits.tolerance)
        self.state = replace(
            s,
            motion=message.number,
            motion_state=MotionState.MOVING if ready else MotionState.STOPPED,
            ride=ride if ready else None,
            force_before=s.force.force(s.zero).average,
            taken=self.now,
            watched=self.now,
        )

    def _stop(self, state: MotionState) -> None:
        """Begin to brake, where the arm is led."""
        if self.state.ride is not None:
            self.state = replace(self.state, ride=None, motion_state=state)
            self.commands.append(Brake())
            self.braking = True

    # --- what must hold

    def _look(self, measured: MeasuredState) -> None:
        """Check what must hold, and lead the hand on."""
        reason = safety_stop(measured.safety_bits)
        if reason is None and self.state.engaged and not measured.program:
            reason = (
                f"the control script ended: it was stopped at the pendant, by its watchdog or by an error; {NEW_RUN}"
            )
        reason = reason or self.state.standing.reason()
        if reason is None and self.state.ride is not None:
            reason = self._neglected()
        if reason is None and self.state.guarded:
            reason = self._passed()
        if reason is not None:
            self._fail(reason)
        elif self.state.ride is not None:
            self._lead(self.state.ride)

    def _neglected(self) -> str | None:
        """Return that the run is silent, or hangs."""
        if (silent := self.now - self.state.heard) > self.settings.heartbeat:
            return f"the run gave no sign of life for {silent:.2g} s; see what held it up, then {NEW_RUN}"
        if (unwatched := self.now - self.state.watched) > self.settings.unwatched:
            return UNWATCHED.format(unwatched)
        return None

    def _passed(self) -> str | None:
        """Return which limit is passed, by an arm that moves or stands."""
        s = self.state
        assert s.measured is not None
        speed = math.hypot(*s.measured.speed[:3])
        past = beyond(self.settings, s.pose.position, speed, s.force.force(s.zero), s.contact_height)
        return past and f"{past}; see why, move the hand back at the pendant where it is still past it, then {NEW_RUN}"

    def _lead(self, ride: Ride) -> None:
        s, contact = self.state, self.settings.contact_force
        ride = ride.at(self.now, _LEAP / self.settings.rate)
        self.state = replace(s, ride=ride, taken=self.now if self.inputs.taken else s.taken)
        if contact is not None and s.force.force(s.zero).average - s.force_before > contact:
            self._stop(MotionState.BLOCKED)
            return
        judged = ride.judge(s.pose)
        if not isinstance(judged, MotionState):
            self._fail(f"{judged}; then {NEW_RUN}")
        elif judged is not MotionState.MOVING:
            self._stop(judged)
        elif self.now - self.state.taken > _DEAF:
            self._fail(f"the control script takes no commands; {NEW_RUN}")
        else:
            self.commands.append(Servo(self.mounting.in_base(ride.setpoint)))

    def _fail(self, reason: str) -> None:
        """Keep the first fault; whatever moves comes to rest."""
        self._stop(MotionState.STOPPED)
        self.state = replace(self.state, engaged=False, guarded=False, fault=self.state.fault or reason)

    def _say_zeroed(self) -> None:
        """Answer that a zero holds: only after a state that has it, or whoever asked would read one from before."""
        if (number := self.state.zeroing) is not None:
            self.state = replace(self.state, zeroing=None)
            self._say(Zeroed(number))

    def _told(self, measured: MeasuredState) -> ArmState:
        s = self.state
        return ArmState(
            time=measured.time,
            number=s.number,
            q=measured.q,
            pose=s.hand,
            speed=measured.speed,
            wrench=s.force.less(s.zero),
            program=measured.program,
            motion=s.motion,
            motion_state=s.motion_state,
            fault=s.fault,
            engaged=s.engaged,
        )
