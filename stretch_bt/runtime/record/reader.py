"""Reading a record: how it began and ended, its events, and what each tick was handed by the devices."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import DeviceFault, InvalidInput, RecordError
from stretch_bt.frames import Intrinsics
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.runtime.record.channels import FAULT, FILE, MARK, MOTION, TICK, UNANSWERED
from stretch_bt.runtime.record.folder import EVENTS, MCAP, RESULT, RUN, damaged, refuse
from stretch_bt.runtime.record.messages import intrinsics_of, raw_of
from stretch_bt.runtime.record.readings import FRAME, SCHEMAS, read_fault, read_frame, read_reading, read_unanswered
from stretch_bt.runtime.record.scan import ChunkFile
from stretch_bt.runtime.record.written import Mark, Written

__all__ = ["Handed", "RecordReader"]


@dataclass(frozen=True, slots=True)
class Handed:
    """Something that a device handed to a node.

    `name` is the name of the reading, the owner of the motion, or empty for a fault; `value` is a Reading, a MotionState or
    a DeviceFault.
    """

    kind: Literal["reading", "motion", "fault", "unanswered"]
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

    Of a record whose process was killed it reads the ticks that were committed; `complete` is then False. Anything that is
    not as it was written is an error. Frames are read from the disk when they are asked for.

    Parameters
    ----------
    folder
        The folder of the record.
    changed_log
        Whether events.jsonl may be another than was written, as long as it can be read; `damage` then says where.

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
    has_readings : bool
        Whether the record holds what the devices read, or the events alone.
    complete : bool
        Whether the record was closed.
    damage : RecordError or None
        Where events.jsonl is not as it was written.

    Raises
    ------
    RecordError
        The folder is missing, holds no record, one that is damaged, or one that would take too much memory.
    """

    def __init__(self, folder: Path, *, changed_log: bool = False) -> None:
        self.folder = Path(folder).absolute()
        if self.folder.is_file():
            beside = (self.folder.parent / EVENTS).is_file()
            hint = f"name the folder that it is in, {self.folder.parent}" if beside else "name the folder of a record"
            raise refuse(self.folder, "record-folder", "this is a file; a record is a folder", hint)
        if not self.folder.is_dir():
            raise refuse(self.folder, "record-missing", "there is no such folder", "name the folder of a record")
        written = Written(self.folder / EVENTS)
        self.header = written.header
        self.ticks: list[tuple[int, float]] = []
        self._handed: dict[int, list[_Message]] = {}
        self._stored: dict[tuple[str, int], tuple[int, int]] = {}
        self._decoded: dict[str, tuple[int, npt.NDArray[np.uint16]]] = {}
        self._calibrations: dict[tuple[str, int], Intrinsics] = {}
        self._chunks = ChunkFile(self.folder / MCAP)
        self._marks: list[Mark] = []
        self._files: dict[str, str] = {}
        self.has_readings = written.header.get("readings") is not False
        if self.has_readings:
            self._index(written)
            self.complete = RESULT in self._files if written.marked else self._chunks.whole
        else:
            self.complete = _read_json(self.folder / RESULT) is not None
        if self.has_readings and self.complete and not self._chunks.whole:  # a recorder writes both at once
            what = "a closed record ends with its whole index"
            raise self._damaged(f"it is cut off at byte {self._chunks.end}, or goes on there: {what}")
        self.events, self.damage = self._events(written)
        if not self.has_readings:
            self.ticks = list(
                {e["tick"]: (e["tick"], float(e["time"])) for e in self.events if e["tick"] >= 0}.values()
            )
        self.run_info: dict[str, Any] = self._other(RUN) or {}
        self.result = self._other(RESULT)
        if self.damage is not None and not changed_log:
            raise self.damage

    @property
    def until(self) -> float:
        """Run time, s, of the last tick that is whole; 0 where none is."""
        return self.ticks[-1][1] if self.ticks else 0.0

    def handed(self, tick: int) -> list[Handed]:
        """Return everything that nodes were handed in a tick, in order; tick -1 is what came before the first."""
        return [self._object(message) for message in self._handed.get(tick, [])]

    def readings(self, tick: int, *, frames: bool = True) -> list[tuple[str, str, Reading[Any]]]:
        """Return the device, name and reading of each reading in a tick, in order; with or without the readings of frames."""
        found = [m for m in self._handed.get(tick, []) if frames or m.schema != FRAME]
        return [(h.device, h.name, h.value) for h in map(self._object, found) if h.kind == "reading"]

    def framed(self) -> dict[str, list[int]]:
        """Return for each camera the ticks in which it handed out frames, rising; reads none of them."""
        found: dict[str, list[int]] = {}
        for tick in sorted(self._handed):
            for device in dict.fromkeys(m.device for m in self._handed[tick] if m.schema == FRAME):
                found.setdefault(device, []).append(tick)
        return found

    def intrinsics(self, device: str) -> Intrinsics | None:
        """Return the intrinsics of a camera's first frame, None of one that gave none."""
        for tick in sorted(self._handed):
            for message in self._handed[tick]:
                if message.schema == FRAME and message.device == device:
                    found: Intrinsics = self._object(message).value.value.intrinsics
                    return found
        return None

    def motions(self, tick: int) -> list[tuple[str, str, MotionState]]:
        """Return the device, owner and state of each polled motion in a tick, in order."""
        return [(h.device, h.name, h.value) for h in self.handed(tick) if h.kind == "motion"]

    def faults(self, tick: int) -> list[tuple[str, DeviceFault]]:
        """Return the device and fault of each fault in a tick, in order."""
        return [(h.device, h.value) for h in self.handed(tick) if h.kind == "fault"]

    def _events(self, written: Written) -> tuple[list[dict[str, Any]], RecordError | None]:
        """Return the events, and where they are not as they were written."""
        if not written.marked:
            return written.unmarked(), None
        chunks = self._chunks
        if not self._marks or (not self.complete and self._marks[-1].events < written.size):
            raise self._damaged(f"it is cut off at byte {chunks.end}, and events.jsonl goes on")
        return written.events(self._marks, self.complete)

    def _other(self, name: str) -> dict[str, Any] | None:
        """Return the content of one of the small files, held against the digest of what was written."""
        path, stated = self.folder / name, self._files.get(name)
        content = _read_json(path)
        if stated is not None and (content is None or hashlib.sha256(path.read_bytes()).hexdigest() != stated):
            found = "is not as it was written" if path.is_file() else "is missing"
            raise damaged(path, f"this file {found}")
        return content

    def _index(self, written: Written) -> None:
        """Take up the messages of all ticks that both files hold as a whole."""
        if not self._chunks.path.is_file():
            raise self._damaged("this file is missing")
        names = _Names()
        tick, count, offset = -1, 0, 0
        waiting: list[tuple[str, Any, Any, tuple[int, int]]] = []
        try:
            for offset, records in self._chunks:
                for position, record in enumerate(records):
                    schema, channel = names.of(record)
                    if not schema:
                        continue
                    if schema == MARK:
                        mark = self._mark(record, count)
                        if mark.events <= written.size:
                            tick = self._take_all(tick, waiting)
                        waiting = []
                    elif schema == FILE:
                        fields = json.loads(record.data)
                        self._files[fields["name"]] = fields["sha256"]
                    else:
                        waiting.append((schema, channel, record, (offset, position)))
                    count += 1
            if not written.marked:
                self._take_all(tick, waiting)
        except InvalidInput as error:
            raise self._damaged(str(error)) from error
        except (LookupError, TypeError, ValueError, RecursionError) as error:
            raise self._damaged(f"its chunk at byte {offset} does not belong here: {error!r}") from error

    def _mark(self, message: Any, count: int) -> Mark:
        """Take note of a mark, before which there were so many messages."""
        fields = json.loads(message.data)
        if fields["messages"] != count:
            raise ValueError(f"{count} messages come before it, and {fields['messages']} were written")
        mark = Mark(fields["events"], fields["crc32"])
        self._marks.append(mark)
        return mark

    def _damaged(self, message: str) -> RecordError:
        return damaged(self._chunks.path, message)

    def _take_all(self, tick: int, messages: Sequence[tuple[str, Any, Any, tuple[int, int]]]) -> int:
        """Index messages; return the tick that the last belongs to."""
        for message in messages:
            tick = self._take(tick, *message)
        return tick

    def _take(self, tick: int, schema: str, channel: Any, message: Any, place: tuple[int, int]) -> int:
        """Index one message; return the tick that it belongs to."""
        if schema in ("foxglove.RawImage", "foxglove.CameraCalibration"):
            self._stored[channel.topic, message.sequence] = place
        elif schema == TICK:
            fields = json.loads(message.data)
            tick = fields["tick"]
            self.ticks.append((tick, float(fields["time"])))
        elif schema in SCHEMAS or schema in (MOTION, FAULT, UNANSWERED):
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
        if message.schema == UNANSWERED:
            return Handed("unanswered", device, "", read_unanswered(fields))
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


def _read_json(path: Path) -> dict[str, Any] | None:
    if not path.is_file():  # a pipe would be waited for
        return None
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None
