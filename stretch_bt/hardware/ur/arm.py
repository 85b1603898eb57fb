"""A UR5 or UR5e."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar

import numpy as np

from stretch_bt.errors import BeyondLimits, DeviceFault, DeviceLost, NotReady
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.driver import ArmDriver, Poll
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.latched import NEW_RUN
from stretch_bt.hardware.motion.path import PosePath
from stretch_bt.hardware.transforms import pose_of, transform, transform_of
from stretch_bt.hardware.ur.arm_process import ArmProcess
from stretch_bt.hardware.ur.look import look
from stretch_bt.hardware.ur.messages import ArmState
from stretch_bt.hardware.ur.options import UrOptions
from stretch_bt.hardware.ur.reach import Reach
from stretch_bt.hardware.ur.zeroing import Zeroing
from stretch_bt.hardware.wire_thread import Sample

__all__ = ["MOST_POSES", "UrArm"]

#: how long a motion may take to begin, and the arm to be ready, s
_BEGINNING = 1.0
#: poses of one path: with numbers of full length they fit into one message to the process
MOST_POSES = 5000


class UrArm(ArmDriver):
    """A UR5 or UR5e by RTDE through ur-rtde, in a process of its own; the hand is led along its path by the controller's servo."""

    streams = True
    Options = UrOptions
    options: UrOptions
    packages: ClassVar[Mapping[str, str]] = dict.fromkeys(("rtde_receive", "rtde_control"), "ur-rtde")
    _process: ArmProcess | None = None
    #: the fault that was raised already, and whether what is left on the controller was
    _told: str | None = None
    _told_program = False

    def claimed(self) -> str:
        """Return which controller it is."""
        return f"the arm at {self.options.host}"

    def open(self) -> None:
        """Connect, and make ready to move; moves nothing, and refuses a controller that runs another program or is stopped."""
        self.open_to_read()
        try:
            self._engage(self._opened())
        except BaseException:
            self.close()
            raise

    def open_to_read(self) -> None:
        """Connect without a program on the controller; motions are refused."""
        hand, o = self.cell.hand, self.options
        process = ArmProcess(self.name, o.settings(self.cell), self.cell.now, lambda: hand.contact_height)
        try:
            process.supervisor.start()
        except DeviceLost as lost:
            raise DeviceLost(self.name, f"cannot be reached at {o.host} ({lost.reason})") from lost
        self._process, self._told, self._told_program = process, None, False

    def findings(self) -> Iterator[Finding]:
        """Yield what ports, dashboard and the limits of the cell look like."""
        yield from look(self.name, self.options, self.cell.limits)

    def close(self) -> None:
        """Disconnect; the control script ends. Raises DeviceLost where it cannot be seen that it ended."""
        process = self._process
        if process is not None:
            process.supervisor.end()
            self._process = None
            self._tell_program(process)

    def stop(self) -> None:
        """Brake; raises DeviceLost where the command cannot be sent and the program is not seen to end: then the watchdog stops the arm."""
        process = self._process
        if process is None:
            return
        try:
            process.stop()
        except DeviceLost:
            process.supervisor.wait_for_end()
            self._tell_program(process)

    def follow(self, path: Sequence[Pose], speed: float) -> Poll:
        """Move through the poses in straight lines, without stopping at them.

        Raises
        ------
        BeyondLimits
            The path has more than `MOST_POSES` poses, the arm cannot reach a pose on the way, or would have to turn too fast.
        NotReady
            The arm is in fault, or was opened to be read.
        """
        process = self._opened()
        if len(path) > MOST_POSES:
            what = f"a path takes at most {MOST_POSES} poses, and this one has {len(path)}"
            raise BeyondLimits(self.name, f"{what}; leave out poses that lie between others, or follow it in parts")
        state = self._checked(process).value
        if not state.engaged:
            raise NotReady(self.name, f"it takes no motions: {state.fault or 'it is not ready'}")
        slow = self._slowed([self._in_world(state), *path], speed, state)
        number, due = process.follow(path, slow), time.monotonic() + _BEGINNING

        def poll() -> MotionState:
            process.watch()
            now = self._checked(process).value
            if now.motion == number:
                return now.motion_state
            if time.monotonic() > due:
                raise DeviceFault(self.name, f"it did not begin within {_BEGINNING:g} s; {NEW_RUN}")
            return MotionState.MOVING

        return poll

    def pose(self) -> Reading[Pose]:
        """Return the latest measured pose of the hand; raises once for a fault that came while nothing was commanded."""
        sample = self._checked(self._opened())
        return Reading(self._in_world(sample.value), sample.value.time, sample.time, sample.number)

    def wrench(self) -> Reading[Wrench]:
        """Return the controller's estimate of the wrench that the world exerts on the hand, averaged, in world axes."""
        sample = self._checked(self._opened())
        turn = self.options.base.pose.matrix()
        felt = np.array(sample.value.wrench)
        (fx, fy, fz), (tx, ty, tz) = (turn @ felt[:3]).tolist(), (turn @ felt[3:]).tolist()
        return Reading(Wrench((fx, fy, fz), (tx, ty, tz)), sample.value.time, sample.time, sample.number)

    def force_noise(self) -> float:
        """Return the noise of the controller's force, N s^0.5 an axis."""
        noise: float = self.options.force_noise()
        return noise

    @property
    def process(self) -> int | None:
        """Number of the process that has the controller's clients."""
        return None if self._process is None else self._process.supervisor.pid

    def _opened(self) -> ArmProcess:
        if self._process is None:
            raise NotReady(self.name, "the device is closed")
        return self._process

    def _checked(self, process: ArmProcess) -> Sample[ArmState]:
        """Return the newest state; raises for a fault that was not reported yet."""
        sample = process.latest()
        fault = sample.value.fault
        if fault is not None and fault != self._told:
            self._told = fault
            raise DeviceFault(self.name, fault)
        return sample

    def _tell_program(self, process: ArmProcess) -> None:
        """Raise, once, that it cannot be seen that no program of this run is left on the controller."""
        if not self._told_program and (unseen := process.unseen_program()) is not None:
            self._told_program = True
            raise DeviceLost(self.name, unseen)

    def _engage(self, process: ArmProcess) -> None:
        zeroing = Zeroing(self.name, self.options, process)
        zeroing.before_program()
        if (reason := process.engage()) is not None:
            raise DeviceFault(self.name, reason)
        due = time.monotonic() + _BEGINNING
        while not (state := process.latest().value).engaged or state.fault is not None:
            if time.monotonic() > due:
                raise DeviceFault(self.name, state.fault or "it did not become ready")
            time.sleep(0.005)
        zeroing.after_program()
        # limits are held from now on: a force can be compared with its own once its zero is known
        if (reason := process.guard()) is not None:
            raise DeviceFault(self.name, reason)

    def _in_world(self, state: ArmState) -> Pose:
        return pose_of(transform_of(self.options.base.pose) @ transform(state.pose))

    def _slowed(self, poses: Sequence[Pose], speed: float, state: ArmState) -> float:
        """Return the speed, m/s, that the joints allow on a path; raises BeyondLimits for a path that the arm cannot follow."""
        o = self.options
        reach = Reach(o.model, o.base.pose, o.hand.pose, joint_speed=o.joint_speed, margin=o.margin)
        path = PosePath(poses)
        obstacle = reach.obstacle(path, speed, state.q)
        if obstacle is not None:
            raise BeyondLimits(self.name, obstacle.reason, obstacle.concerns)
        return reach.slowed(path, speed, state.q)
