"""Reading a record: how it began and ended, its events, and what each tick was handed by the devices."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import DeviceFault, InvalidInput
from stretch_bt.frames import Intrinsics
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.run.record.channels import FAULT, MOTION, TICK
from stretch_bt.run.record.folder import EVENTS, FORMAT, MCAP, RESULT, RUN, refuse
from stretch_bt.run.record.messages import intrinsics_of, raw_of
from stretch_bt.run.record.readings import FRAME, SCHEMAS, read_fault, read_frame, read_reading
from stretch_bt.run.record.scan import ChunkFile

__all__ = ["Handed", "RecordReader"]


@dataclass(frozen=True, slots=True)
class Handed:
    """Something that a device handed to a node.

    `name` is that of the reading, the owner of the motion, or empty for a fault; `value` is a Reading, a MotionState or
    a DeviceFault.
    """

    kind: Literal["reading", "motion", "fault"]
    device: str
    name: str
    value: Any


@dataclass(frozen=True, slots=True)
class _Message:
    schema: str
    device: str
    name: str
    fields: dict[str, Any]


class RecordReader:
    """Reads a record folder.

    Of a record whose process was killed it reads as far as it goes; `complete` is then False, and the last tick may
    lack what came after its last committed chunk. Frames are read from the disk when they are asked for.

    Attributes
    ----------
    header, run_info : dict
        What the record was started with.
    result : dict or None
        What it was closed with.
    events : list of dict
        The lines of events.jsonl after the header.
    ticks : list of (int, float)
        Number and time, s, of each tick.
    complete : bool
        Whether the record was closed.

    Raises
    ------
    RecordError
        The folder is missing, or holds no record, or one that would take too much memory.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder).absolute()
        if not self.folder.is_dir():
            raise refuse(self.folder, "record-missing", "there is no such folder", "name the folder of a record")
        self.header, self.events, events_whole = _read_events(self.folder / EVENTS)
        self.run_info: dict[str, Any] = _read_json(self.folder / RUN) or {}
        self.result = _read_json(self.folder / RESULT)
        self.ticks: list[tuple[int, float]] = []
        self._handed: dict[int, list[_Message]] = {}
        self._stored: dict[tuple[str, int], tuple[int, int]] = {}
        self._decoded: dict[str, tuple[int, npt.NDArray[np.uint16]]] = {}
        self._calibrations: dict[tuple[str, int], Intrinsics] = {}
        self._chunks = ChunkFile(self.folder / MCAP)
        try:
            self._index()
        except InvalidInput as error:
            raise refuse(self._chunks.path, "record-damaged", str(error)) from error
        self.complete = events_whole and self._chunks.whole and self.result is not None

    def handed(self, tick: int) -> list[Handed]:
        """Return everything that nodes were handed in a tick, in order; tick -1 is what came before the first."""
        return [self._object(message) for message in self._handed.get(tick, [])]

    def readings(self, tick: int, *, frames: bool = True) -> list[tuple[str, str, Reading[Any]]]:
        """Return the device, name and reading of each reading in a tick, in order; with or without those of frames."""
        found = [m for m in self._handed.get(tick, []) if frames or m.schema != FRAME]
        return [(h.device, h.name, h.value) for h in map(self._object, found) if h.kind == "reading"]

    def framed(self) -> dict[str, list[int]]:
        """Return for each camera the ticks in which it handed out frames, rising; reads none of them."""
        found: dict[str, list[int]] = {}
        for tick in sorted(self._handed):
            for device in dict.fromkeys(m.device for m in self._handed[tick] if m.schema == FRAME):
                found.setdefault(device, []).append(tick)
        return found

    def motions(self, tick: int) -> list[tuple[str, str, MotionState]]:
        """Return the device, owner and state of each polled motion in a tick, in order."""
        return [(h.device, h.name, h.value) for h in self.handed(tick) if h.kind == "motion"]

    def faults(self, tick: int) -> list[tuple[str, DeviceFault]]:
        """Return the device and fault of each fault in a tick, in order."""
        return [(h.device, h.value) for h in self.handed(tick) if h.kind == "fault"]

    def _index(self) -> None:
        if not self._chunks.path.is_file():
            return
        names = _Names()
        tick = -1
        for offset, records in self._chunks:
            for position, record in enumerate(records):
                try:
                    tick = self._take(tick, *names.of(record), record, (offset, position))
                except KeyError:  # what the message refers to was in a chunk that is lost
                    return

    def _take(self, tick: int, schema: str, channel: Any, message: Any, place: tuple[int, int]) -> int:
        """Index one message; return the tick that it belongs to."""
        if schema in ("foxglove.RawImage", "foxglove.CameraCalibration"):
            self._stored[channel.topic, message.sequence] = place
        elif schema == TICK:
            fields = json.loads(message.data)
            tick = fields["tick"]
            self.ticks.append((tick, float(fields["time"])))
        elif schema in SCHEMAS or schema in (MOTION, FAULT):
            fields = json.loads(message.data)
            device = channel.metadata.get("device", "") or fields["device"]
            if schema == FRAME and not self._stored.keys() >= set(_stored_with(device, fields)):
                raise KeyError(device)
            name = channel.metadata.get("name", "")
            self._handed.setdefault(tick, []).append(_Message(schema, device, name, fields))
        return tick

    def _object(self, message: _Message) -> Handed:
        device, fields = message.device, message.fields
        if message.schema == MOTION:
            return Handed("motion", device, fields["owner"], MotionState(fields["state"]))
        if message.schema == FAULT:
            return Handed("fault", device, "", read_fault(fields))
        if message.schema == FRAME:
            image, calibration = _stored_with(device, fields)
            reading = read_frame(fields, self._image(*image), self._intrinsics(*calibration))
            return Handed("reading", device, message.name, reading)
        return Handed("reading", device, message.name, read_reading(message.schema, fields))

    def _image(self, topic: str, number: int) -> npt.NDArray[np.uint16]:
        last = self._decoded.get(topic)
        if last is None or last[0] != number:
            last = number, raw_of(self._data(topic, number))
            last[1].flags.writeable = False
            self._decoded[topic] = last
        return last[1]

    def _intrinsics(self, topic: str, number: int) -> Intrinsics:
        if (topic, number) not in self._calibrations:
            self._calibrations[topic, number] = intrinsics_of(self._data(topic, number))
        return self._calibrations[topic, number]

    def _data(self, topic: str, number: int) -> bytes:
        offset, position = self._stored[topic, number]
        data: bytes = self._chunks.at(offset)[position].data
        return data


class _Names:
    """The schemas and channels that the chunks so far have declared."""

    def __init__(self) -> None:
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, Any] = {}

    def of(self, record: Any) -> tuple[str, Any]:
        """Return the schema and channel of a message; of anything else an empty name and None."""
        from mcap.records import Channel, Message, Schema

        if isinstance(record, Message):
            channel = self._channels[record.channel_id]
            return self._schemas[channel.schema_id], channel
        if isinstance(record, Schema):
            self._schemas[record.id] = record.name
        elif isinstance(record, Channel):
            self._channels[record.id] = record
        return "", None


def _stored_with(device: str, fields: dict[str, Any]) -> tuple[tuple[str, int], tuple[str, int]]:
    """Return the topic and number of a frame's image and of its calibration."""
    value = fields["value"]
    return (f"/{device}/depth", value["image"]), (f"/{device}/calibration", value["calibration"])


def _read_events(path: Path) -> tuple[dict[str, Any], list[dict[str, Any]], bool]:
    """Return the header, the events, and whether the last line is whole."""
    if not path.is_file():
        raise refuse(path, "record-missing", "there is no such file; this folder is not a record", "name a record")
    events = []
    whole = True
    with path.open("rb") as file:
        for line in file:
            event = _read_line(line)
            if event is None:
                whole = False
                break
            events.append(event)
    header = events.pop(0) if events else {}
    if header.get("type") != "header" or header.get("format") != FORMAT:
        raise refuse(path, "record-format", f"the first line is not the header of a {FORMAT}", "name a record")
    return header, events, whole


def _read_line(line: bytes) -> dict[str, Any] | None:
    try:
        event = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return event if isinstance(event, dict) and line.endswith(b"\n") else None


def _read_json(path: Path) -> dict[str, Any] | None:
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None
