"""Readings as JSON messages and back, without loss; a depth frame refers to its image, which is stored apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from stretch_bt import errors
from stretch_bt.errors import DeviceFault, NoAnswer
from stretch_bt.frames import DepthFrame, Pose, Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.runtime.record.plain import plain

__all__ = [
    "FRAME",
    "SCHEMAS",
    "frame_fields",
    "read_fault",
    "read_frame",
    "read_reading",
    "read_unanswered",
    "reading_fields",
]

T = TypeVar("T")

NUMBER, POSE, WRENCH, FRAME, VALUE = (
    f"stretch.{name}" for name in ("NumberReading", "PoseReading", "WrenchReading", "DepthFrameReading", "Reading")
)
_VECTORS: dict[type, tuple[str, str, str]] = {
    Pose: (POSE, "position", "rotation"),
    Wrench: (WRENCH, "force", "torque"),
}
_FRAME_FIELDS = ("unit", "time", "sequence", "plane_distance", "hand_height", "stretch")


def _schema(title: str, value: Mapping[str, Any]) -> dict[str, Any]:
    number = {"type": "number"}
    properties = {"value": value, "device_time": number, "host_time": number, "sequence": {"type": "integer"}}
    return {"title": title, "type": "object", "properties": properties}


def _object(*names: str, **kind: Any) -> dict[str, Any]:
    return {"type": "object", "properties": dict.fromkeys(names, kind)}


_VECTOR = {"type": "array", "items": {"type": "number"}}
_POSE = _object("position", "rotation", **_VECTOR)
_FRAME = _object("image", "calibration", *_FRAME_FIELDS, type="number")
_FRAME["properties"]["pose"] = _POSE
SCHEMAS: dict[str, dict[str, Any]] = {
    NUMBER: _schema("A number, SI", {"type": "number"}),
    POSE: _schema("Pose of the hand in the world, m and rad", _POSE),
    WRENCH: _schema("Wrench on the hand in world axes, N and N m", _object("force", "torque", **_VECTOR)),
    FRAME: _schema("A depth frame, SI; pose of the hand in the world, m and rad", _FRAME),
    VALUE: _schema("A reading", {}),
}


def reading_fields(reading: Reading[Any]) -> tuple[str, dict[str, Any]]:
    """Return the schema and the message of a reading that is not a frame."""
    value = reading.value
    if value.__class__ in _VECTORS:
        schema = _VECTORS[value.__class__][0]
        content: Any = _vectors(value)
    else:
        content = plain(value)
        schema = NUMBER if isinstance(value, int | float) and not isinstance(value, bool) else VALUE
    return schema, _with_times(reading, content)


def frame_fields(reading: Reading[DepthFrame], image: int, calibration: int) -> dict[str, Any]:
    """Return the message of a frame whose image and intrinsics are stored under these numbers."""
    known = {name: plain(getattr(reading.value, name)) for name in _FRAME_FIELDS}
    content = {name: value for name, value in known.items() if value is not None}
    if reading.value.pose is not None:
        content["pose"] = _vectors(reading.value.pose)
    return _with_times(reading, {**content, "image": image, "calibration": calibration})


def _vectors(value: Any) -> dict[str, Any]:
    _, *names = _VECTORS[value.__class__]
    return {name: _plain_list(getattr(value, name)) for name in names}


def _plain_list(values: Any) -> list[Any]:
    return [plain(value) for value in values]


def _with_times(reading: Reading[Any], content: Any) -> dict[str, Any]:
    times = {"device_time": plain(reading.device_time), "host_time": plain(reading.host_time)}
    return {"value": content, "sequence": plain(reading.sequence), **times}


def read_reading(schema: str, fields: Mapping[str, Any]) -> Reading[Any]:
    """Return the reading that `reading_fields` turned into this message; a value of another class stays plain."""
    return _reading(fields, _VALUE_READERS.get(schema, _as_is)(fields["value"]))


def read_frame(fields: Mapping[str, Any], image: Any, intrinsics: Any) -> Reading[DepthFrame]:
    """Return the reading of a frame, given its image and intrinsics."""
    rest = {name: _number(fields["value"].get(name)) for name in _FRAME_FIELDS}
    placed = fields["value"].get("pose")
    pose = None if placed is None else _pose(placed)
    return _reading(fields, DepthFrame(raw=image, intrinsics=intrinsics, pose=pose, **rest))


def _reading(fields: Mapping[str, Any], value: Any) -> Reading[Any]:
    return Reading(value, _number(fields["device_time"]), _number(fields["host_time"]), fields["sequence"])


def _number(value: Any) -> Any:
    return float(value) if isinstance(value, str) else value


def _vector(values: Any) -> tuple[Any, ...]:
    return tuple(_number(value) for value in values)


def _pose(fields: Mapping[str, Any]) -> Pose:
    return Pose(_vector(fields["position"]), _vector(fields["rotation"]))


def _as_is(value: Any) -> Any:
    return value


_VALUE_READERS: dict[str, Callable[[Any], Any]] = {
    NUMBER: _number,
    POSE: _pose,
    WRENCH: lambda value: Wrench(_vector(value["force"]), _vector(value["torque"])),
}


def _kinds(base: type[T]) -> dict[str, type[T]]:
    found = (getattr(errors, name) for name in errors.__all__)
    return {kind.__name__: kind for kind in found if issubclass(kind, base)}


_FAULTS, _NO_ANSWERS = _kinds(DeviceFault), _kinds(NoAnswer)


def read_fault(fields: Mapping[str, Any]) -> DeviceFault:
    """Return the fault that a message names; one of an unknown kind comes back as a DeviceFault."""
    kind = _FAULTS.get(fields["kind"])
    if kind is None:
        return DeviceFault(fields["device"], fields["reason"])
    return kind(**{name: value for name, value in fields.items() if name != "kind"})


def read_unanswered(fields: Mapping[str, Any]) -> NoAnswer:
    """Return the NoAnswer that a message names; one of an unknown kind comes back as a NoAnswer."""
    return _NO_ANSWERS.get(fields["kind"], NoAnswer)(fields["reason"])
