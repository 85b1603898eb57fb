"""A RealSense depth camera."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from typing import ClassVar

from stretch_bt.errors import DeviceFault, DeviceLost, NotReady
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.driver import DepthCameraDriver
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.latched import NEW_RUN
from stretch_bt.hardware.messages import Message
from stretch_bt.hardware.realsense.inbox import CameraState, Inbox
from stretch_bt.hardware.realsense.judge import FrameCounters
from stretch_bt.hardware.realsense.look import look
from stretch_bt.hardware.realsense.messages import CODEC, Next
from stretch_bt.hardware.realsense.options import RealsenseOptions
from stretch_bt.hardware.supervisor import Deadlines, ProcessProgram, Supervisor

__all__ = ["RealsenseCamera"]

_MODULE = "stretch_bt.hardware.realsense.process"
#: longer than the deadlines of the process, which say more
_DEADLINES = Deadlines(opening=15.0, silence=1.5, ending=3.0)


class RealsenseCamera(DepthCameraDriver):
    """A RealSense camera through pyrealsense2 in a process of its own, a recording of one, or the software device on a stand-in."""

    streams = True
    Options = RealsenseOptions
    options: RealsenseOptions
    packages: ClassVar[Mapping[str, str]] = {"pyrealsense2": "'stretch-bt[realsense]'"}
    _supervisor: Supervisor | None = None
    _inbox: Inbox | None = None
    _over = False

    @property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the lens, as the camera reports them; raises NotReady before it was connected."""
        found = None if self._inbox is None else self._inbox.intrinsics
        if found is None:
            raise NotReady(self.name, "a camera reports its lens when it is connected; open it first")
        return found

    @property
    def ended(self) -> bool:
        """Whether a recording was played to its end."""
        return self._over

    @property
    def process(self) -> int | None:
        """Number of the process that has librealsense."""
        return None if self._supervisor is None else self._supervisor.pid

    def claimed(self) -> str | None:
        """Return which camera it is; a recording or a stand-in may be read by more than one program."""
        serial = self.options.serial
        return None if serial is None else f"the camera {serial}"

    def open(self) -> None:
        """Connect and wait for a first good frame; raises DeviceLost when none comes."""
        o = self.options
        inbox = Inbox(
            latency=o.latency if o.file is None else 0.0,
            plane_distance=o.plane_distance,
            now=lambda: (self.cell.now(), time.monotonic()),
        )
        program = ProcessProgram(_MODULE, CODEC, [o.settings(self.cell.root)], [inbox.descriptor])
        supervisor = Supervisor(self.name, program, _DEADLINES, take=self._take, after=inbox.close)
        self._inbox, self._supervisor, self._over = inbox, supervisor, False
        try:
            supervisor.start()
        except DeviceLost as lost:
            self.close()
            raise DeviceLost(self.name, f"no frames from {o.place}: {lost.reason}") from lost
        except BaseException:  # such as Ctrl-C
            self.close()
            raise

    def close(self) -> None:
        """End the stream, and a recording of it."""
        supervisor, self._supervisor, self._over = self._supervisor, None, False
        if supervisor is not None:
            supervisor.end()

    def frame(self) -> Reading[DepthFrame]:
        """Return the newest good frame.

        Raises
        ------
        DeviceLost
            No good frame came for too long, its process ended, or the recording did.
        DeviceFault
            Once for a camera that was restarted or whose clock jumped, and for a silence that is over.
        """
        return self._checked().latest

    def counters(self) -> FrameCounters:
        """Return how many frames came, and how many did not, or not as they should, since the camera was opened."""
        supervisor, state = self._opened()
        supervisor.check_connected()
        return state.counters

    def findings(self) -> Iterator[Finding]:
        """Yield whether the camera, recording or stand-in is there."""
        yield from look(self.name, self.options, self.cell.root)

    def _take(self, message: Message) -> bool:
        supervisor, inbox = self._supervisor, self._inbox
        if supervisor is None or inbox is None:  # it is being closed
            return False
        if inbox.take(message):
            supervisor.reply(Next())
        if inbox.state is not None:
            self._over = self._over or inbox.state.ended  # the end of a recording stays one
        return inbox.state is not None

    def _opened(self) -> tuple[Supervisor, CameraState]:
        if self._supervisor is None or self._inbox is None or self._inbox.state is None:
            raise NotReady(self.name, "the device is closed")
        return self._supervisor, self._inbox.state

    def _checked(self) -> CameraState:
        supervisor, state = self._opened()
        if self._over:
            raise DeviceLost(self.name, "end of recording")
        supervisor.check_connected()
        if self._inbox is not None and (event := self._inbox.event()) is not None:
            raise DeviceFault(self.name, f"{event}; look at its cable and supply, then {NEW_RUN}")
        if state.silent > self.options.lost_after:
            why = state.bad or "nothing came"
            raise DeviceLost(
                self.name, f"no good frame for {state.silent:.2g} s: {why}; check its cable and port, then {NEW_RUN}"
            )
        return state
