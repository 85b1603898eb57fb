"""The driver: the bag is read as time passes, so that a long one needs no memory."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore

from stretch_bt.devices import (
    DepthCameraDriver,
    DepthFrame,
    DeviceLost,
    Intrinsics,
    Mistake,
    NotReady,
    Reading,
    Within,
)
from stretch_bt.units import Length
from stretch_bt_ros_bag.images import counts, lens, seconds


class BagCamera(DepthCameraDriver):
    """Plays the depth pictures of a ROS 2 bag from the moment it is opened; then it is lost: end of recording."""

    @dataclass(frozen=True)
    class Options:
        """The options of a cell file."""

        bag: str  # folder of the bag, relative to the cell file
        topic: str = "/camera/depth/image_rect_raw"  # sensor_msgs/Image, 16UC1 or 32FC1
        info: str = "/camera/depth/camera_info"  # sensor_msgs/CameraInfo of the same pictures
        plane_distance: Annotated[Length, Within(0.02, 2, "Length")] | None = None  # camera to the flat membrane

        def mistakes(self, root: Path) -> Iterator[Mistake]:
            """Yield when there is no bag, or when it lacks a topic."""
            path = root / self.bag
            if not (path / "metadata.yaml").is_file():
                yield "bag", f"there is no ROS 2 bag {self.bag!r}", "write its folder, relative to the cell file"
                return
            with _reader(path) as reader:
                known = sorted(reader.topics)
            for option, topic in (("topic", self.topic), ("info", self.info)):
                if topic not in known:
                    yield option, f"the bag has no topic {topic!r}", f"it has {', '.join(known)}"

    options: Options
    _reader: AnyReader | None = None
    _lens: Intrinsics | None = None
    _latest: Reading[DepthFrame] | None = None
    _next: Reading[DepthFrame] | None = None
    _period = 0.0

    @property
    def intrinsics(self) -> Intrinsics:
        """The lens, from the bag."""
        if self._lens is None:
            raise NotReady(self.name, "the bag has not been opened, so that its lens is not known yet")
        return self._lens

    @property
    def ended(self) -> bool:
        """Whether the last frame has had its time; `frame` then raises, and a node that asks first ends without a fault."""
        if self._reader is None or self._latest is None:
            return False
        self._advance()
        return self._next is None and self.now() > self._latest.host_time + self._period

    def open(self) -> None:
        """Read the lens and the first two pictures, and begin to play."""
        try:
            reader = _reader(self.folder / self.options.bag)
            reader.open()
            self._reader = reader
            infos = self._messages(self.options.info)
            self._lens = lens(next(infos))
            self._images = self._messages(self.options.topic)
            self._start = self.now()
            self._zero: float | None = None
            self._latest, self._next = self._read(0), self._read(1)
        except (AnyReaderError, StopIteration, ValueError, KeyError) as error:
            raise DeviceLost(self.name, f"the bag {self.options.bag} cannot be played: {error}") from error

    def close(self) -> None:
        """Let go of the bag."""
        reader, self._reader = self._reader, None
        if reader is not None:
            reader.close()

    def frame(self) -> Reading[DepthFrame]:
        """Return the picture that is due; raises DeviceLost at the end."""
        if self._reader is None or self._latest is None:
            raise NotReady(self.name, "the device is closed")
        if self.ended:
            raise DeviceLost(self.name, "end of recording")
        return self._latest

    def _advance(self) -> None:
        """Go on to the picture that is due now."""
        while self._latest is not None and self._next is not None and self._next.host_time <= self.now():
            self._period = self._next.host_time - self._latest.host_time
            self._latest, self._next = self._next, self._read(self._next.sequence + 1)

    def _read(self, number: int) -> Reading[DepthFrame] | None:
        """Return the next picture, which is due as long after the opening as it was taken after the first."""
        image = next(self._images, None)
        if image is None:
            return None
        taken = seconds(image.header.stamp)
        self._zero = taken if self._zero is None else self._zero
        raw, unit = counts(image)
        distance = self.options.plane_distance
        frame = DepthFrame(raw, unit, self.intrinsics, taken, number, plane_distance=distance)
        return Reading(frame, taken, self._start + taken - self._zero, number)

    def _messages(self, topic: str) -> Iterator[Any]:
        assert self._reader is not None
        wanted = [c for c in self._reader.connections if c.topic == topic]
        for connection, _, data in self._reader.messages(connections=wanted) if wanted else ():
            yield self._reader.deserialize(data, connection.msgtype)


def _reader(path: Path) -> AnyReader:
    return AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
