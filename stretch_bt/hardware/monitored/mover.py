"""Ownership of motion: the newest command has the device, and only its owner's handle can stop it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeVar

from stretch_bt.errors import DeviceFault, NoAnswer, StretchError
from stretch_bt.hardware.asked import check_asked
from stretch_bt.hardware.driver import Driver, Poll
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.monitored.base import Monitored, Watch
from stretch_bt.hardware.owner import check_owner

__all__ = ["Mover", "OwnedMotion"]

D = TypeVar("D", bound=Driver)


class OwnedMotion:
    """A motion that a node started; once it has ended, its state stays."""

    def __init__(self, device: Mover[Any], owner: str, poll: Poll) -> None:
        self.owner = owner
        self.ended: MotionState | None = None
        self._device = device
        self._poll = poll

    def poll(self) -> MotionState:
        """Return how the motion stands now; raises DeviceFault when the device failed."""
        state = self.ended or self._device.poll_current(self)
        self._device.watch.journal.motion(self._device.name, self.owner, state)
        return state

    def refresh(self) -> MotionState:
        """Ask the driver, and remember an end."""
        if self.ended is None:
            state = MotionState(self._poll())
            if state is MotionState.DONE:
                self._device.check_arrival()
            self.ended = None if state is MotionState.MOVING else state
            return state
        return self.ended

    def stop(self) -> None:
        """Stop the motion if it is still its device's current one; otherwise do nothing."""
        if self.ended is None:
            self._device.command("stop", {}, self.owner)
            self._device.stop()


class Mover(Monitored[D]):
    """A device that moves."""

    def __init__(self, name: str, driver: D, watch: Watch) -> None:
        super().__init__(name, driver, watch)
        self._current: OwnedMotion | None = None

    def check_command(self, owner: str, arguments: Mapping[str, Any] = MappingProxyType({})) -> None:
        """Raise NotReady unless the device takes commands, and InvalidInput for an owner that is none or for arguments without sense."""
        self.check_ready()
        check_owner(self.name, owner)
        check_asked(self.name, arguments)

    def settle(self) -> None:
        """Take note of a motion that has ended by now, before a new command makes its end unknown."""
        if self._current is not None:
            with self.faults():
                self._current.refresh()

    def own(self, poll: Poll, owner: str) -> OwnedMotion:
        """Return the handle of the motion that the driver has just accepted; the one before it ends as preempted, unless it had ended."""
        if self._current is not None:
            self._current.ended = self._current.ended or MotionState.PREEMPTED
        self._current = OwnedMotion(self, owner, poll)
        return self._current

    def poll_current(self, motion: OwnedMotion) -> MotionState:
        """Return how the device's current motion stands; raises the latched fault if there is one."""
        if self.fault is not None:
            raise self.fault
        with self.faults():
            state = motion.refresh()
        if state is MotionState.MOVING:
            self.guard()
        return state

    def release(self, owner: str) -> None:
        """Stop the motion that an owner left under way; does nothing where another one has the device, or a fault has stopped it."""
        motion = self._current
        if self.fault is not None or motion is None or motion.owner != owner or motion.ended is not None:
            return
        try:
            moves = motion.poll() is MotionState.MOVING
        except NoAnswer:  # it cannot be looked at
            moves = True
        except StretchError:
            motion.stop()
            raise
        if moves:
            motion.stop()

    def check_arrival(self) -> None:
        """Raise DeviceFault where the driver says that a motion is done, and the device is elsewhere."""

    def guard(self) -> None:
        """Check the limits that hold while the device moves."""

    def stop(self) -> None:
        """End any motion at once, whoever owns it."""
        try:
            super().stop()
        finally:
            if self._current is not None:
                self._current.ended = self._current.ended or MotionState.STOPPED
                self._current = None

    def halt(self, fault: DeviceFault) -> None:
        """Stop because of a fault that the cell found, keep it, and raise it."""
        self.latch(fault)
        self.stop()
        raise fault
