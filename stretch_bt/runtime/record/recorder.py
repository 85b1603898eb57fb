"""The record of a run while it is written: events, readings, and at the end the result."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.errors import DeviceFault, InvalidInput, NoAnswer, RecordError
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.runtime.record.channels import FAULT, MOTION, TICK, UNANSWERED, WRITE, Channels, nanoseconds
from stretch_bt.runtime.record.events import EventLog
from stretch_bt.runtime.record.folder import EVENTS, MCAP, RESULT, RUN, Kept, claim, not_empty, refuse
from stretch_bt.runtime.record.images import Images
from stretch_bt.runtime.record.messages import log_line, point_cloud
from stretch_bt.runtime.record.places import Places
from stretch_bt.runtime.record.plain import plain
from stretch_bt.runtime.record.readings import FRAME, frame_fields, reading_fields

__all__ = ["RunRecord"]

_LEVELS = {"fault": "ERROR", "error": "ERROR", "stop_error": "ERROR", "finally": "WARNING", "overrun": "WARNING"}


class _Streams:
    """The files that grow during a run: the events, and the readings of the devices where they are kept."""

    def __init__(self, folder: Path, header: Any, run_info: bytes, *, readings: bool) -> None:
        self.events = EventLog(folder / EVENTS, header, beside=readings)
        self.channels = Channels(folder / MCAP, header) if readings else None
        self.images = None if self.channels is None else Images(self.channels)
        if self.channels is not None:
            self.channels.file(RUN, run_info)
        self.commit()

    def commit(self) -> None:
        # events come last: no event may be on the disk whose readings are not
        if self.channels is not None:
            self.channels.commit(self.events.size, self.events.crc32)
        self.events.commit()

    def close(self, result: bytes) -> None:
        """End both; that the result is noted says that the record was closed, so the index goes to the disk with it."""
        if self.channels is not None:
            self.channels.file(RESULT, result)
            self.channels.mark(self.events.size, self.events.crc32)
            self.channels.close()
        self.events.close()

    def abandon(self) -> None:
        _try(self.events.abandon)
        if self.channels is not None:
            _try(self.channels.abandon)


class RunRecord:
    """Writes a record folder; is the journal of the cell.

    What a tick writes reaches the operating system when the next one begins, so a killed process loses one tick at
    most. A disk that fails raises RecordError once, from `begin_tick` or `close`; from then on the record takes nothing
    more, and what was written before stays readable. All calls come from the thread that ticks.

    Parameters
    ----------
    folder
        Where it is kept: an empty folder, or one that is made; by default a new one under ./runs.
    kept
        `full`, `events` without what the devices read, or `none`: then there is no folder, and every call does nothing.
    """

    def __init__(self, folder: Path | None = None, kept: Kept = "full") -> None:
        self.folder = None if kept == "none" else claim(folder)
        self._readings = kept == "full"
        self._streams: _Streams | None = None
        self._moment: dict[str, Any] = {"tick": -1, "time": 0.0}
        self._motions: dict[tuple[str, str], MotionState] = {}
        self._places = Places()
        self._closed = False
        self._broken = False

    def start(self, header: Mapping[str, Any], run_info: Mapping[str, Any], places: Places | None = None) -> None:
        """Begin: `header` is the same for identical runs, `run_info` may hold paths, host and wall time.

        The texts that follow are written without `places`. The header's `keys` (name to type name), where it has them, give the
        plots of the report their units.
        """
        if self.folder is None:
            return
        self._places = places or self._places
        try:
            content = _write_json(self.folder / RUN, run_info, new=True)
            self._streams = _Streams(self.folder, plain(header), content, readings=self._readings)
        except FileExistsError:  # another program has begun a record here since
            self._closed = True
            raise not_empty(self.folder) from None
        except OSError as error:
            raise self._break(error) from error

    def begin_tick(self, tick: int, time: float) -> None:
        """Commit what came before; from now on everything belongs to this tick, at `time`, s."""
        self._moment = {"tick": int(tick), "time": plain(time)}
        if self._streams is None:
            return
        try:
            self._streams.commit()
        except OSError as error:
            raise self._break(error) from error
        if self._streams.channels is not None:
            self._streams.channels.now = nanoseconds(time)
            self._streams.channels.json("/ticks", TICK, self._moment)

    def status(self, path: str, status: str, reason: str = "") -> None:
        """Take note that a node came to another status."""
        fields = {"path": path, "status": status}
        if reason:
            fields["reason"] = reason = self._places.without(reason)
        level = "WARNING" if status == "FAILURE" else "INFO"
        self._event("status", fields, path, f"{status} {reason}".rstrip(), level)

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Take note that a node wrote a key; `sd` is None where the value carries no standard deviation.

        A `value` of None says that the key was left without one.
        """
        if self._streams is None:
            return
        fields = {"value": self._places.left_out(plain(value)), "path": path}
        if sd is not None:
            fields["sd"] = plain(sd)
        self._streams.events.event({**fields, "key": key, **self._moment, "type": "write"})
        channels = self._streams.channels
        if channels is None:
            return
        channels.json(f"/keys/{key}", WRITE, fields)
        points = getattr(value, "points", None)
        if isinstance(points, np.ndarray) and points.ndim == 2 and points.shape[1] == 3:
            channels.proto(f"/keys/{key}", point_cloud(points, "membrane", channels.now))

    def reading(self, device: str, name: str, reading: Reading[Any]) -> None:
        """Take note that a node was given this reading."""
        if self._streams is None or self._streams.channels is None or self._streams.images is None:
            return
        if isinstance(reading.value, DepthFrame):
            schema, fields = FRAME, frame_fields(reading, **self._streams.images.store(device, reading.value))
        else:
            schema, fields = reading_fields(reading)
        self._streams.channels.json(f"/{device}/{name}", schema, fields, device=device, name=name)

    def command(self, device: str, name: str, arguments: Mapping[str, Any], owner: str) -> None:
        """Take note that a node gave this command."""
        self._motions.pop((device, owner), None)
        given = self._places.left_out(plain(arguments))
        fields = {"device": device, "name": name, "arguments": given, "owner": owner}
        self._event("command", fields, owner, f"{device}.{name}")

    def motion(self, device: str, owner: str, state: MotionState) -> None:
        """Take note of a polled motion: every poll goes to the mcap file, a change to the events as well."""
        if self._streams is None:
            return
        fields = {"device": device, "owner": owner, "state": state.value}
        self._message(f"/{device}/motion", MOTION, fields)
        if self._motions.get((device, owner)) is not state:
            self._motions[device, owner] = state
            self._event("motion", fields, owner, f"{device} {state.value}")

    def fault(self, device: str, fault: DeviceFault) -> None:
        """Take note that a device fault reached a node."""
        if self._streams is None:
            return
        fields = {"device": device, "kind": type(fault).__name__, "reason": self._places.without(fault.reason)}
        self._message(f"/{device}/fault", FAULT, {**fault.fields(), **fields})
        self._event("fault", fields, device, f"{fields['kind']}: {fields['reason']}")

    def unanswered(self, device: str, none: NoAnswer) -> None:
        """Take note that a device had no answer for a node."""
        if self._streams is None:
            return
        fields = {"device": device, "kind": type(none).__name__, "reason": self._places.without(none.reason)}
        self._message(f"/{device}/unanswered", UNANSWERED, fields)
        self._event("unanswered", fields, device, fields["reason"], "WARNING")

    def note(self, kind: str, **fields: Any) -> None:
        """Take note of anything else that a reader of the log should know, such as `overrun` or `stop`."""
        if not fields.keys().isdisjoint(("tick", "time", "type")):
            raise InvalidInput(f"the fields of a note are not named tick, time or type, got {sorted(fields)}")
        content = self._places.left_out(plain(fields))
        self._event(kind, content, kind, " ".join(f"{name}={value}" for name, value in content.items()))

    def _message(self, topic: str, schema: str, fields: Mapping[str, Any]) -> None:
        if self._streams is not None and self._streams.channels is not None:
            self._streams.channels.json(topic, schema, fields)

    def _event(self, kind: str, fields: dict[str, Any], source: str, text: str, level: str = "INFO") -> None:
        if self._streams is None:
            return
        self._streams.events.event({**fields, **self._moment, "type": kind})
        channels = self._streams.channels
        if channels is not None:
            channels.proto("/log", log_line(_LEVELS.get(kind, level), source, text, channels.now))

    def close(self, result: Mapping[str, Any]) -> None:
        """Write the result and close every file; a second call does nothing.

        The result is written also where the other files cannot be.
        """
        if self._closed or self.folder is None:
            return
        self._closed = True
        streams, self._streams = self._streams, None
        error = _try(streams.commit) if streams is not None else None
        try:
            content = _write_json(self.folder / RESULT, result)
            if streams is not None and error is None:
                streams.close(content)
        except OSError as refused:
            error = error or refused
        if streams is not None:
            streams.abandon()
        if error is not None and not self._broken:
            raise self._break(error) from error

    def _break(self, error: OSError) -> RecordError:
        """Leave the files as they are, take nothing more, and say why."""
        self._broken = True
        if self._streams is not None:
            self._streams.abandon()
        self._streams = None
        assert self.folder is not None
        return refuse(self.folder, "record-write", f"cannot write the record: {error.strerror or error}")


def _write_json(path: Path, content: Mapping[str, Any], *, new: bool = False) -> bytes:
    """Write a file, and return what it holds; raises FileExistsError where it is to be `new` and is not."""
    text = (json.dumps(plain(content), indent=2, allow_nan=False) + "\n").encode()
    with path.open("xb" if new else "wb") as file:
        file.write(text)
    return text


def _try(step: Callable[[], None]) -> OSError | None:
    try:
        step()
    except OSError as error:
        return error
    return None
