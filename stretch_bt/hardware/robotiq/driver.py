"""What the drivers of Robotiq 2F grippers share, whatever they reach the gripper by."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable

from stretch_bt.errors import BeyondLimits, DeviceFault, DeviceLost, InvalidInput, NotReady
from stretch_bt.hardware.driver import GripperDriver, Poll
from stretch_bt.hardware.interfaces import UNWATCHED, MotionState, Reading
from stretch_bt.hardware.robotiq.options import RobotiqOptions
from stretch_bt.hardware.robotiq.registers import PASSING, ActivationStage, Status
from stretch_bt.hardware.robotiq.screened_wire import ScreenedWire
from stretch_bt.hardware.robotiq.tasks import Activation, GripperTask, Journey, Target, fault_in, lost_activation
from stretch_bt.hardware.robotiq.wire import GripperWire
from stretch_bt.hardware.wire_thread import Sample, WireThread

__all__ = ["RobotiqDriver"]

#: exchanges of a command beside its read and the read of a poll under way: what each of the two sends, and one that is tried
#: again, with connecting
_EXCHANGES = 6
#: periods of polling without an answer after which it is lost at the earliest
_PERIODS = 3


class RobotiqDriver(GripperDriver, ABC):
    """A 2F gripper on some wire. It is asked for its status all the time, because it counts a second of silence as a fault."""

    streams = True

    options: RobotiqOptions
    _attendant: WireThread[ScreenedWire, Status] | None = None
    _task: GripperTask | None = None
    #: whether the fingers may be on their way, and no hold of them was confirmed since
    _owed = False
    #: whether it moved the fingers since it was opened; who never did holds nothing that somebody else moves
    _moved = False
    _known: Status | None = None
    _event: DeviceFault | None = None
    _watched = 0.0

    @abstractmethod
    def _wire(self) -> GripperWire:
        """Return a wire that is not connected."""

    def open(self) -> None:
        """Connect and read the status; an inactive gripper can be read, but not moved."""
        self._task = self._known = self._event = None
        self._owed = self._moved = False
        wire = self._wire()
        exchanges = 2 * wire.exchanges + _EXCHANGES
        attendant = WireThread(
            self.name,
            ScreenedWire(wire, self.cell.now),
            period=1 / self.options.rate,
            deadline=max(exchanges * self.options.timeout, _PERIODS / self.options.rate),
            now=self.cell.now,
            after_poll=self._after,
            at_loss=self._hold_at_loss,
            hint="check its line, and raise `timeout` if it is slow",
        )
        attendant.start()
        self._attendant = attendant

    def unready(self) -> str | None:
        """Return that it is not activated, or its fault."""
        try:
            self._check_ready(self.status())
        except DeviceFault as fault:
            return fault.reason
        return None

    def close(self) -> None:
        """Disconnect."""
        attendant, self._attendant = self._attendant, None
        if attendant is not None:
            attendant.end()

    def stop(self) -> None:
        """Hold the fingers where they are, if it was this driver that moved them; raises as `hold` does."""
        if self._moved:
            self.hold()

    def hold(self) -> None:
        """Hold the fingers where they are, whoever moves them; an activation is broken off.

        Raises
        ------
        DeviceLost
            They were moving, and the command to hold them could not be sent, on a new connection either.
        """
        if self._attendant is None:
            return

        def hold(wire: ScreenedWire) -> None:
            activating, self._task = (
                self._activating,
                None,
            )  # here, so that a motion that was about to begin does not come after it
            _hold(wire, activating)
            self._owed = False

        try:
            self._attendant.do(hold)
        except DeviceLost as lost:
            self._attendant.wait_for_end()
            self._task = None
            if self._owed:
                self._owed = False  # it is reported now
                reason = f"the stop cannot be sent ({lost.reason}); the fingers may go on to where they were sent"
                raise DeviceLost(self.name, reason) from lost

    def activate(self) -> Poll:
        """Reset and activate the gripper: the fingers travel all their way."""
        return self._begin(lambda wire: Activation(self.name, self.cell.now()))

    def move(self, opening: float, speed: float) -> Poll:
        """Move the fingers to an opening, m; raises BeyondLimits where none was calibrated, NotReady without activation."""
        try:
            count = self.options.calibration.count(opening)
        except InvalidInput as error:
            raise BeyondLimits(self.name, str(error), ("stretch",)) from None

        def journey(wire: GripperWire) -> Journey:
            status = wire.read()
            self._check_ready(status)
            return self._journey(opening, count, speed, self._measured(status))

        return self._begin(journey)

    def opening(self) -> Reading[float]:
        """Return the opening that the gripper reports, m.

        Raises
        ------
        DeviceLost
            The connection was lost.
        DeviceFault
            Once: a fault or the end of the activation, which the gripper reported while it stood.
        """
        sample = self._open().latest()
        event, self._event = self._event, None
        if event is not None:
            raise event
        return Reading(self._measured(sample.value), sample.time, sample.time, sample.number)

    def status(self) -> Status:
        """Ask the gripper for its status now; raises DeviceLost."""
        return self._open().refresh().value

    def count(self) -> int:
        """Return the position that the gripper reports now, 0 to 255; raises DeviceLost."""
        return self.status().position

    def _open(self) -> WireThread[ScreenedWire, Status]:
        if self._attendant is None:
            raise NotReady(self.name, "the device is closed")
        return self._attendant

    @property
    def _activating(self) -> bool:
        return isinstance(self._task, Activation) and not self._task.over

    def _measured(self, status: Status) -> float:
        return self.options.calibration.opening(status.position)

    def _journey(self, opening: float, count: int, speed: float, start: float) -> Journey:
        slowest, _ = self.options.speeds
        target = Target(
            opening,
            count,
            start,
            speed,
            (self.options.speed_count(speed), self.options.force),
            led=speed < slowest * (1 - 1e-9),
        )
        return Journey(self.name, target, self.cell.now(), self.options.calibration, self.options.tolerance)

    def _check_ready(self, status: Status) -> None:
        """Raise unless the gripper takes motions; faults that the next command clears do not keep it from one."""
        fault = fault_in(self.name, status)
        if fault is not None and status.fault not in PASSING:
            raise fault
        if not status.ready:
            state = "is being activated" if status.stage is ActivationStage.ACTIVATING else "is not activated"
            reason = (
                f"it {state}; take the membrane off, keep clear of the fingers, which travel all their way, "
                "and run: stretch-bt activate CELL"
            )
            raise NotReady(self.name, reason)

    def _begin(self, make: Callable[[GripperWire], GripperTask]) -> Poll:
        attendant = self._open()
        attendant.check_connected()
        due = time.monotonic() + attendant.deadline

        def begin(wire: GripperWire) -> GripperTask:
            task = make(wire)
            if time.monotonic() > due:  # its caller has given up
                raise DeviceLost(self.name, "the command came too late to be begun")
            # before it is sent: where the answer is lost, the fingers may go on all the same
            self._task, self._watched, self._owed = task, time.monotonic(), True
            try:
                task.begin(wire)
            except DeviceFault:  # it was not begun; a wire that breaks is no such fault
                self._task, self._owed = None, False
                raise
            return task

        moved, self._moved = self._moved, True  # before it is asked for: a stop may come while it begins
        try:
            task = attendant.do(begin)
        except NotReady:
            self._moved = moved
            raise

        def poll() -> MotionState:
            self._watched = time.monotonic()
            if task.fault is not None:
                self._event = None  # it is reported here, also where the wire broke after it
            else:
                attendant.latest()
            return task.poll()

        return poll

    def _after(self, wire: ScreenedWire, sample: Sample[Status]) -> None:
        task, status = self._task, sample.value
        if task is None or task.over or not isinstance(task, Activation):
            self._event = self._event or self._news(status)
        self._known = status
        if task is not None and not task.over:
            task.after(wire, status, sample.time)
            if task.fault is None and task.state is not MotionState.MOVING:
                self._owed = False  # they arrived, or were held where they are blocked
            unwatched = time.monotonic() - self._watched
            if not task.over and unwatched > self.cell.limits.unwatched:
                activating = self._activating
                self._event = task.fault = DeviceFault(self.name, UNWATCHED.format(unwatched))
                _hold(wire, activating)
                self._owed = False

    def _news(self, status: Status) -> DeviceFault | None:
        """Return what went wrong between the status before and this one."""
        known = self._known
        if known is None:
            return None
        if status.fault not in (0, known.fault, *PASSING):
            return fault_in(self.name, status)
        return lost_activation(self.name) if known.ready and not status.ready else None

    def _hold_at_loss(self, wire: ScreenedWire) -> None:
        """Keep the fingers from going on to where they were sent before a loss."""
        if self._moved:
            _hold(wire, self._activating)
            self._owed = False


def _hold(wire: ScreenedWire, activating: bool) -> None:
    """Hold the fingers, whatever they say of their position; to an inactive gripper nothing is written, because that would activate it.

    An activation of our own is broken off whatever the gripper says: it may not say yet that it has begun.
    """
    status = wire.bare.read()
    if activating or status.stage is ActivationStage.ACTIVATING:
        wire.reset()
    elif status.ready:
        wire.hold(status)
