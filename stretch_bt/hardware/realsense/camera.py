"""A RealSense depth camera."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from stretch_bt.errors import DeviceFault, DeviceLost, NotReady
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.attendant import Attendant, Sample
from stretch_bt.hardware.driver import CameraDriver
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.realsense.judge import Counters
from stretch_bt.hardware.realsense.link import CameraLink, CameraState
from stretch_bt.hardware.realsense.look import look
from stretch_bt.hardware.realsense.options import RealsenseOptions

__all__ = ["RealsenseCamera"]

#: above all deadlines of the link, which tell more
_DEADLINE = 15.0


class RealsenseCamera(CameraDriver):
    """A RealSense camera through pyrealsense2 in a process of its own, a recording of one, or the software device on a stand-in."""

    Options = RealsenseOptions
    options: RealsenseOptions
    packages: ClassVar[Mapping[str, str]] = {"pyrealsense2": "'stretch-bt[realsense]'"}
    _attendant: Attendant[CameraLink, CameraState] | None = None
    _link: CameraLink | None = None
    _over = False

    @property
    def intrinsics(self) -> Intrinsics:
        """What the camera tells of its lens; raises NotReady before it was connected."""
        found = None if self._link is None else self._link.intrinsics
        if found is None:
            raise NotReady(self.name, "a camera tells of its lens when it is connected; open it first")
        return found

    @property
    def ended(self) -> bool:
        """Whether a recording was played to its end."""
        return self._over

    @property
    def process(self) -> int | None:
        """Number of the process that has librealsense."""
        return None if self._link is None else self._link.pid

    def open(self) -> None:
        """Connect and wait for a first good frame; raises DeviceLost when none comes."""
        o = self.options
        link = CameraLink(
            self.name,
            o.settings(self.bench.root),
            latency=o.latency if o.file is None else 0.0,
            plane_distance=o.plane_distance,
            now=self.bench.now,
        )
        attendant = Attendant(
            self.name,
            link,
            period=0.0,
            deadline=_DEADLINE,
            now=self.bench.now,
            after_poll=self._after,
            on_return=lambda _: None,
        )
        self._link, self._attendant, self._over = link, attendant, False
        try:
            attendant.start()
        except DeviceLost as lost:
            self.close()
            raise DeviceLost(self.name, f"no frames from {o.place}: {lost.reason}") from lost
        except BaseException:  # such as Ctrl-C
            self.close()
            raise

    def close(self) -> None:
        """End the stream, and a recording of it."""
        attendant, self._attendant, self._over = self._attendant, None, False
        if attendant is not None and self._link is not None:
            self._link.leave()
            attendant.end()

    def acknowledge(self) -> None:
        """Go on after a fault that is over; raises DeviceFault while it lasts."""
        if self._attendant is not None and self._link is not None:
            self._attendant.acknowledge()
            self._link.event()
            self._checked()

    def frame(self) -> Reading[DepthFrame]:
        """Return the newest good frame.

        Raises
        ------
        DeviceLost
            No good frame came for too long, its process ended, or the recording did; once for a loss that is over.
        DeviceFault
            Once for a camera that was restarted or whose clock jumped, and for a silence that is over.
        """
        return self._checked().latest

    def counters(self) -> Counters:
        """Return how many frames came, and how many did not, or not as they should, since the process was begun."""
        return self._opened().latest().value.counters

    def findings(self) -> Iterator[Finding]:
        """Yield whether the camera, recording or stand-in is there."""
        yield from look(self.name, self.options, self.bench.root)

    def _after(self, link: CameraLink, sample: Sample[CameraState]) -> None:
        self._over = self._over or sample.value.ended  # the end stays one, also when its process is begun anew

    def _opened(self) -> Attendant[CameraLink, CameraState]:
        if self._attendant is None:
            raise NotReady(self.name, "the device is closed")
        return self._attendant

    def _checked(self) -> CameraState:
        attendant, link = self._opened(), self._link
        if self._over:
            raise DeviceLost(self.name, "end of recording")
        state = attendant.latest().value
        if link is not None and (event := link.event()) is not None:
            raise DeviceFault(self.name, f"{event}; look at its cable and supply, then acknowledge")
        if state.silent > self.options.lost_after:
            why = state.bad or "nothing came"
            raise DeviceLost(
                self.name, f"no good frame for {state.silent:.2g} s: {why}; check its cable and port, then acknowledge"
            )
        return state
