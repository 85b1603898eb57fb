"""A UR5 or UR5e."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar

import numpy as np

from stretch_bt.errors import DeviceFault, DeviceLost, LimitExceeded, NotReady
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.attendant import Sample
from stretch_bt.hardware.channel import ChannelClosed
from stretch_bt.hardware.driver import ArmDriver, Poll
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.simulated.path import PosePath
from stretch_bt.hardware.transforms import pose_of, transform, transform_of
from stretch_bt.hardware.ur.look import look
from stretch_bt.hardware.ur.options import UrOptions
from stretch_bt.hardware.ur.reach import Reach
from stretch_bt.hardware.ur.settings import ArmState
from stretch_bt.hardware.ur.supervisor import Supervisor

__all__ = ["UrArm"]

_ENGAGING, _STOPPING, _BEGINNING = 10.0, 1.0, 1.0
_TARE_OVER = 0.2


class UrArm(ArmDriver):
    """A UR5 or UR5e by RTDE through ur-rtde, in a process of its own; the hand is led along its path by the controller's servo."""

    Options = UrOptions
    options: UrOptions
    packages: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("rtde_receive", "rtde_control", "dashboard_client"), "ur-rtde"
    )
    _supervisor: Supervisor | None = None
    _told: str | None = None
    _moving: int | None = None
    _was_ready = False

    def open(self) -> None:
        """Connect, and make ready to move; moves nothing, and refuses a controller that runs another program or is stopped."""
        self.open_to_read()
        try:
            self._engage(self._opened(), unlock=False, tare=self.options.tare)
        except BaseException:
            self.close()
            raise

    def open_to_read(self) -> None:
        """Connect without a program on the controller; motions are refused until `acknowledge`."""
        hand = self.bench.hand
        supervisor = Supervisor(
            self.name, self.options.settings(self.bench), self.bench.now, lambda: hand.contact_height
        )
        supervisor.start()
        self._supervisor, self._told, self._moving, self._was_ready = supervisor, None, None, False

    def findings(self) -> Iterator[Finding]:
        """Yield what ports, dashboard and the limits of the cell look like."""
        yield from look(self.name, self.options, self.bench.limits)

    def close(self) -> None:
        """Disconnect; the control script ends."""
        supervisor, self._supervisor = self._supervisor, None
        if supervisor is not None:
            supervisor.end()

    def stop(self) -> None:
        """Brake; raises DeviceLost when that cannot be told, and then the controller's watchdog does it."""
        if self._supervisor is None:
            return
        moving, self._moving = self._moving, None
        try:
            self._supervisor.ask({"do": "stop"}, _STOPPING)
        except DeviceLost as lost:
            if moving is not None:
                seconds = 1 / self.options.watchdog
                reason = f"it cannot be told to stop ({lost.reason}); the controller's watchdog stops it within {seconds:.2g} s"
                raise DeviceLost(self.name, reason) from lost

    def acknowledge(self) -> None:
        """Take motions again: unlocks a protective stop and runs the control script again, if need be; moves nothing."""
        supervisor = self._supervisor
        if supervisor is None:
            return
        supervisor.acknowledge()
        state = supervisor.latest().value
        if not state.engaged or state.fault is not None:
            self._engage(supervisor, unlock=True, tare=False)
        self._told = None

    def follow(self, path: Sequence[Pose], speed: float) -> Poll:
        """Move through the poses in straight lines, without stopping at them.

        Raises
        ------
        LimitExceeded
            The arm cannot reach a pose on the way, or would have to turn too fast.
        NotReady
            A fault was not acknowledged.
        """
        supervisor = self._opened()
        supervisor.check_acknowledged()
        state = self._checked(supervisor).value
        if not state.engaged:
            raise NotReady(self.name, f"it takes no motions: {state.fault or 'it is not ready'}")
        self._check_reach([self._in_world(state), *path], speed, state)
        number, due = supervisor.number(), time.monotonic() + _BEGINNING
        six = [[*pose.position, *pose.rotation] for pose in path]
        try:
            supervisor.send({"do": "follow", "number": number, "path": six, "speed": speed})
        except ChannelClosed as error:
            raise DeviceLost(self.name, f"the connection broke ({error})") from error
        self._moving = number

        def poll() -> MotionState:
            supervisor.watch()
            now = self._checked(supervisor).value
            if now.motion != number:
                if time.monotonic() > due:
                    raise DeviceFault(self.name, f"it did not begin within {_BEGINNING:g} s; acknowledge to go on")
                return MotionState.MOVING
            ended = MotionState(now.motion_state)
            if ended is not MotionState.MOVING and self._moving == number:
                self._moving = None
            return ended

        return poll

    def pose(self) -> Reading[Pose]:
        """Return the latest measured pose of the hand; raises once for a fault that came while nothing was commanded."""
        sample = self._checked(self._opened())
        return Reading(self._in_world(sample.value), sample.value.time, sample.time, sample.number)

    def wrench(self) -> Reading[Wrench]:
        """Return the controller's estimate of the wrench that the world exerts on the hand, in world axes."""
        sample = self._checked(self._opened())
        turn = self.options.base.pose.matrix()
        felt = np.array(sample.value.wrench)
        (fx, fy, fz), (tx, ty, tz) = (turn @ felt[:3]).tolist(), (turn @ felt[3:]).tolist()
        return Reading(Wrench((fx, fy, fz), (tx, ty, tz)), sample.value.time, sample.time, sample.number)

    @property
    def process(self) -> int | None:
        """Number of the process that has the controller's clients."""
        return None if self._supervisor is None else self._supervisor.pid

    def _opened(self) -> Supervisor:
        if self._supervisor is None:
            raise NotReady(self.name, "the device is closed")
        return self._supervisor

    def _checked(self, supervisor: Supervisor) -> Sample[ArmState]:
        """Return the newest state; raises for a fault that was not told yet."""
        sample = supervisor.latest()
        fault = sample.value.fault
        if fault is not None and fault != self._told:
            self._told = fault
            raise DeviceFault(self.name, fault)
        if fault is None:
            self._told = None
        return sample

    def _engage(self, supervisor: Supervisor, *, unlock: bool, tare: bool) -> None:
        reason = supervisor.engage(_ENGAGING, again=self._was_ready, unlock=unlock)
        if reason is not None:
            raise DeviceFault(self.name, reason)
        due = time.monotonic() + _BEGINNING
        while not (state := supervisor.latest().value).engaged or state.fault is not None:
            if time.monotonic() > due:
                raise DeviceFault(self.name, state.fault or "it did not become ready")
            time.sleep(0.005)
        self._was_ready = True
        if tare:
            self._tare(supervisor)
        # limits are held from now on: a force can be compared with its own once its zero is known
        reason = supervisor.ask({"do": "guard"}, _ENGAGING)["reason"]
        if reason is not None:
            raise DeviceFault(self.name, reason)

    def _tare(self, supervisor: Supervisor) -> None:
        samples, end = [], time.monotonic() + _TARE_OVER
        while time.monotonic() < end:
            samples.append(supervisor.latest().value.wrench)
            time.sleep(1 / self.options.rate)
        mean = np.mean(samples, axis=0)
        supervisor.keep_zero(tuple(mean.tolist()))

    def _in_world(self, state: ArmState) -> Pose:
        return pose_of(transform_of(self.options.base.pose) @ transform(state.pose))

    def _check_reach(self, poses: Sequence[Pose], speed: float, state: ArmState) -> None:
        o = self.options
        reach = Reach(o.model, o.base.pose, o.hand.pose, joint_speed=o.joint_speed, margin=o.margin)
        reason = reach.obstacle(PosePath(poses), speed, state.q)
        if reason is not None:
            raise LimitExceeded(self.name, reason)
