"""A stand-in for a depth camera: it feeds librealsense's software device in the process of the camera's driver."""

from __future__ import annotations

import socket
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.faults import Fault
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.tcp_server import TcpServer
from stretch_bt.hardware.realsense.wire import PORT, CameraDescription, SentFrame

__all__ = ["RealsenseStandIn"]

_RATE = 30
_PLANE = Intrinsics(fx=238.0, fy=238.0, cx=160.0, cy=120.0, width=320, height=240)
_UNIT, _NOISE = 0.000125, 3e-4
_PERIOD = 1 / _RATE
#: frames that may be on their way at once, while their pictures are solved
_BEHIND = 3
#: packets that are due and wait for a client which does not read, and all that wait; older ones are left out
_WAITING, _LATEST = 4, 300
_BIT = 1 << 5

Counts = npt.NDArray[np.uint16]
_Due = tuple[float, bytes]

_FAULTS: dict[str, Fault] = {
    "drop": Fault("closes all connections and refuses new ones, as a camera that is unplugged", state=True),
    "reset": Fault("breaks all connections once; new ones are taken", state=True),
    "freeze": Fault("sends nothing, on connections that stay open", state=True),
    "slow": Fault("sends `rate` frames a second, at most its 30", {"rate": 1.0}, state=True),
    "late": Fault("sends each frame `delay` seconds after its time", {"delay": 1.0}, state=True),
    "loss": Fault("leaves out the part `part` of its frames", {"part": 0.3}),
    "reorder": Fault("exchanges the part `part` of its frames with the one after", {"part": 0.3}),
    "repeat": Fault("sends the same frame again and again: number, time and image stand"),
    "clock": Fault("its numbers and images go on, and its time stands"),
    "stale": Fault("its numbers and its time go on, and its image stands"),
    "torn": Fault(
        "the lower part `part` of each image is a copy of that in the image sent before, so that it stands",
        {"part": 0.5},
    ),
    "dark": Fault("no pixel of its images has a value"),
    "restart": Fault("begins its numbers and its time anew; once", state=True),
    "jump": Fault("its clock jumps ahead by `delay` seconds; once", {"delay": 10.0}, state=True),
    "exchange": Fault("is another camera for those that connect from now on", state=True),
    "corrupt": Fault("flips bits of each packet, but not of its checksum"),
    "truncate": Fault("sends the first half of each packet only"),
    "garbage": Fault("sends `bytes` bytes of noise in place of each packet", {"bytes": 64.0}),
}


class RealsenseStandIn(StandIn):
    """A camera at 30 Hz: with a scene the part of the image that shows its membrane, without one a plane of 320 x 240 pixels."""

    PORTS: ClassVar[Mapping[str, int]] = {"depth": PORT}
    FAULTS: ClassVar[Mapping[str, Fault]] = _FAULTS
    SENSES: ClassVar[tuple[str, ...]] = ("seen",)

    def __init__(self, host: str, stage: StandInWorld, ports: Mapping[str, int] | None = None) -> None:
        super().__init__(host, stage, ports)
        self._random = np.random.default_rng(stage.seed)
        self._view = stage.camera(_RATE)
        self._clients: list[deque[_Due]] = []
        self._lock = threading.Lock()
        self._ending, self._due = threading.Event(), threading.Condition()
        self._server: TcpServer | None = None
        self._thread: threading.Thread | None = None
        self._number = self._sent = 0
        self._shift = 0.0
        self._before: Counts | None = None
        self._last: SentFrame | None = None
        self._kept: SentFrame | None = None
        self._seen: DepthFrame | None = None

    def start(self) -> dict[str, str]:
        """Open the port."""
        self._ending.clear()
        while self._view is not None and self._seen is None:  # the first one may take long
            time.sleep(_PERIOD)
            self._seen = self._view.frame(self._now_number())
        self._server = TcpServer(self.host, self.ports["depth"], self._serve, self._refuses)
        self._thread = threading.Thread(target=self._run, name="camera stand-in", daemon=True)
        self._thread.start()
        host, port = self._server.address
        return {"depth": f"{host}:{port}"}

    def stop(self) -> None:
        """Close the port."""
        self._ending.set()
        with self._due:
            self._due.notify_all()
        thread, self._thread = self._thread, None
        server, self._server = self._server, None
        if thread is not None:
            thread.join()
        if server is not None:
            server.stop()

    def state(self) -> dict[str, Any]:
        """Return how many frames went out, how many of them showed what was a little before, and whether a client takes them."""
        late = 0 if self._view is None else self._view.late
        return {"sent": self._sent, "late": late, "streaming": bool(self._clients)}

    def inject(self, fault: str, parameters: Mapping[str, Any] | None = None) -> None:
        """Begin to show a fault."""
        super().inject(fault, parameters)
        if fault in ("drop", "reset") and self._server is not None:
            self._server.break_all(reset=fault == "reset")
        if fault == "restart":
            with self._lock:
                self._number, self._shift = 0, -self._time()
        elif fault == "jump":
            with self._lock:
                self._shift += (self.faults.shown("jump") or {"delay": 0.0})["delay"]
        if fault in ("reset", "restart", "jump"):
            self.clear(fault)

    def _refuses(self) -> bool:
        return self.faults.shown("drop") is not None

    # --- what goes out

    def _serve(self, connection: socket.socket) -> None:
        """Send the description, then what is due, to a client."""
        waiting: deque[_Due] = deque()
        self._send(connection, self._described().encode())
        with self._lock:
            self._clients.append(waiting)
        try:
            while not self._ending.is_set():
                with self._due:
                    self._due.wait_for(lambda: self._ending.is_set() or self._is_due(waiting), timeout=0.05)
                    packet = waiting.popleft()[1] if self._is_due(waiting) else None
                if packet is not None:
                    self._send(connection, packet)
                elif _hung_up(connection):
                    return
        finally:
            with self._lock:
                self._clients.remove(waiting)

    def _is_due(self, waiting: deque[_Due]) -> bool:
        return bool(waiting) and waiting[0][0] <= time.monotonic()

    def _send(self, connection: socket.socket, data: bytes) -> None:
        rest = memoryview(data)
        while rest and not self._ending.is_set():
            with suppress(TimeoutError):
                rest = rest[connection.send(rest) :]

    def _described(self) -> CameraDescription:
        frame = self._seen
        lens, unit = (_PLANE, _UNIT) if frame is None else (frame.intrinsics, frame.unit)
        other = self.faults.shown("exchange") is not None
        return CameraDescription(
            serial="stand-in" if not other else "another",
            width=lens.width,
            height=lens.height,
            rate=_RATE,
            unit=unit,
            fx=lens.fx * (1.1 if other else 1.0),
            fy=lens.fy,
            cx=lens.cx,
            cy=lens.cy,
            distortion=lens.distortion,
        )

    def _run(self) -> None:
        begun, number = 0.0, self._now_number()
        while not self._ending.wait(max((number + 1) * _PERIOD - self.stage.now(), 0.0)):
            number = max(number + 1, self._now_number() - _BEHIND)
            slow, now = self.faults.shown("slow"), time.monotonic()
            waits = self.faults.shown("freeze") is not None or (slow is not None and now < begun + 1 / slow["rate"])
            if self._clients and not waits:
                begun = now
                self._expose(number)

    def _now_number(self) -> int:
        """Return the number of the frame that is exposed now."""
        return int(self.stage.now() * _RATE + 1e-6)

    def _time(self) -> float:
        return time.monotonic() if self._seen is None else self._seen.time

    def _expose(self, number: int) -> None:
        """Give the packets of a frame to all clients."""
        seen = None if self._view is None else self._view.frame(number)
        with self._lock:
            self._seen = seen
            self._number += 1
            for picture in self._in_order(self._faulty(self._plane() if seen is None else seen.raw)):
                self._tell(self._broken(picture.encode()))

    def _tell(self, packet: bytes) -> None:
        late, now = self.faults.shown("late"), time.monotonic()
        self._sent += 1
        with self._due:
            for waiting in self._clients:
                waiting.append((now + (late["delay"] if late else 0.0), packet))
                while sum(due <= now for due, _ in waiting) > _WAITING or len(waiting) > _LATEST:
                    waiting.popleft()
            self._due.notify_all()

    def _faulty(self, image: Counts) -> SentFrame:
        """Return a frame with what the faults make of it."""
        if self.faults.take("dark") is not None:
            image = np.zeros_like(image)
        before, last = self._before, self._last
        if before is not None:
            image = self._old(image, before)
        self._before = image
        if last is not None and self.faults.take("repeat") is not None:
            return last
        stands = last is not None and self.faults.take("clock") is not None
        time_ = last.time if last is not None and stands else self._time() + self._shift
        self._last = SentFrame(self._number, time_, image.astype("<u2").tobytes())
        return self._last

    def _old(self, image: Counts, before: Counts) -> Counts:
        """Return an image of which all, or a part, is of the one before where a fault says so."""
        torn = self.faults.take("torn")
        if self.faults.take("stale") is not None:
            return before
        if torn is not None:
            image = image.copy()
            row = round(len(image) * (1 - torn["part"]))
            image[row:] = before[row:]
        return image

    def _in_order(self, picture: SentFrame) -> Iterator[SentFrame]:
        """Yield the frames that go out for one, which is none for a lost one, or two for one that was kept back."""
        loss, swap = self.faults.take("loss"), self.faults.take("reorder")
        if loss is not None and self._random.random() < loss["part"]:
            return
        kept, self._kept = self._kept, None
        if kept is None and swap is not None and self._random.random() < swap["part"]:
            self._kept = picture
            return
        yield picture
        if kept is not None:
            yield kept

    def _broken(self, packet: bytes) -> bytes:
        """Return what goes out in place of a packet."""
        noise = self.faults.take("garbage")
        if noise is not None:
            return self._random.bytes(int(noise["bytes"]))
        if self.faults.take("truncate") is not None:
            return packet[: len(packet) // 2]
        if self.faults.take("corrupt") is not None:
            changed = bytearray(packet)
            for at in self._random.integers(32, len(packet), 8):
                changed[at] ^= _BIT
            return bytes(changed)
        return packet

    def _plane(self) -> Counts:
        """Return an image of the flat membrane, with noise."""
        shape = (_PLANE.height, _PLANE.width)
        seen = self.stage.geometry.plane_distance + self._random.normal(0.0, _NOISE, shape)
        image: Counts = np.round(seen / _UNIT).astype(np.uint16)
        return image


def _hung_up(connection: socket.socket) -> bool:
    """Return whether the client is gone; it says nothing otherwise."""
    with suppress(TimeoutError):
        connection.setblocking(False)
        try:
            return not connection.recv(1024)
        except BlockingIOError:
            return False
        finally:
            connection.settimeout(0.1)
    return False
