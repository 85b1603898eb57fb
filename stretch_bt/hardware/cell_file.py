"""Cell files: which devices a tree acts on, the hand, and the limits."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal, Union

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from stretch_bt.errors import CellError, Diagnostic, FileError
from stretch_bt.hardware.device_entries import DeviceSpec, imported, read_devices
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.hand_file import FORMAT as HAND_FORMAT
from stretch_bt.hardware.hand_file import HandFile
from stretch_bt.hardware.implementations import Implementations, Unusable
from stretch_bt.hardware.least_force import least_limit
from stretch_bt.hardware.limits import Limits
from stretch_bt.source import Map, Scalar, Value, load, resolve, validate
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["CellSpec", "DeviceSpec", "cell_names", "cell_schema", "load_cell"]

FORMAT = "stretch-cell/1"
_REST = HandGeometry()
#: mistakes in the name of a file rather than in its content
_NO_FILE = ("file-missing", "file-folder", "file-special", "file-unreadable")


class _Hand(BaseModel):
    """Lengths of the hand."""

    model_config = ConfigDict(extra="forbid", strict=True)

    gauge: Annotated[Length, Within(0.01, 1.0, "Length")] = Field(
        default=_REST.gauge, description="length of the membrane between the fingers"
    )
    width: Annotated[Length, Within(0.01, 1.0, "Length")] = Field(
        default=_REST.width, description="width of the membrane"
    )
    thickness: Annotated[Length, Within(0.0001, 0.02, "Length")] = _REST.thickness
    rest_opening: Annotated[Length, Within(0.0, 0.5, "Length")] = Field(
        default=_REST.rest_opening, description="opening of the gripper at stretch 0"
    )
    plane_distance: Annotated[Length, Within(0.02, 2.0, "Length")] = Field(
        default=_REST.plane_distance, description="distance from the camera to the flat membrane"
    )
    calibration: str | None = Field(
        default=None, description="file that `calibrate-hand` wrote, relative to this one, in place of `plane_distance`"
    )


class _Device(BaseModel):
    """One device; its implementation defines the options that follow."""

    model_config = ConfigDict(extra="allow", strict=True)

    type: str
    use: str


class _CellFile(BaseModel):
    """A cell file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    format: Literal["stretch-cell/1"]
    doc: str = ""
    imports: dict[str, str] = Field(
        default={}, description="Python modules with drivers, `name: module`, beside this file or installed"
    )
    devices: dict[str, _Device] = Field(min_length=1)
    hand: _Hand = _Hand()
    limits: Limits = Limits()


@dataclass(frozen=True, slots=True)
class CellSpec:
    """A cell file that was read and found right; nothing is opened."""

    name: str
    path: Path
    doc: str
    hand: HandGeometry
    limits: Limits
    devices: dict[str, DeviceSpec]
    #: top names of the modules that it imports
    imports: tuple[str, ...] = ()

    @property
    def simulated(self) -> bool:
        """Whether any device is simulated, so that the cell needs a scene."""
        return any(device.implementation.cls.simulated for device in self.devices.values())

    def span(self, limit: str) -> tuple[float, float]:
        """Return the least and the greatest value that the cell allows of a limit, SI; a stretch as far as its gripper opens too."""
        low, high = self.limits.span(limit)
        for device in self.devices.values() if limit == "stretch" else ():
            if (ends := device.options.openings()) is not None:
                low, high = max(low, self.hand.stretch(ends[0])), min(high, self.hand.stretch(ends[1]))
        return low, high


def load_cell(cell: str | Path) -> CellSpec:
    """Read a cell file, or a shipped cell by its name; opens nothing.

    Raises
    ------
    CellError
        With every mistake at its line and column, also the mistakes in the files that it names.
    """
    try:
        path = resolve(cell, _shipped(), "cell")
        source = load(path, str(path))
    except FileError as error:
        raise CellError(error.diagnostics) from None
    found: list[Diagnostic] = []
    known = Implementations(imported(source.get("imports"), path, found))
    source, calibration = _calibrated(source, path.parent, known, found)
    devices = read_devices(source.get("devices"), path.parent, known, found)
    try:
        made = validate(_CellFile, source)
    except FileError as error:
        places = {(d.line, d.column) for d in found}
        found += [d for d in error.diagnostics if (d.line, d.column) not in places]
        raise CellError(sorted(found, key=lambda d: (d.line, d.column))) from None
    found += _unheld(source, made.limits, devices)
    if found:
        raise CellError(found)
    hand = HandGeometry(**made.hand.model_dump(exclude={"calibration"}))
    if calibration is not None:
        c = calibration.camera
        hand = replace(hand, plane_distance=c.distance, aim_x=c.aim_x, aim_y=c.aim_y, yaw=c.yaw)
    tops = tuple(sorted({module.partition(".")[0] for module in made.imports.values()}))
    return CellSpec(path.stem, path, made.doc, hand, made.limits, devices, tops)


def _unheld(source: Map, limits: Limits, devices: dict[str, DeviceSpec]) -> Iterator[Diagnostic]:
    """Yield that the cell's limit of force is one that the noise of its arm passes: the arm's own process holds it, nothing else."""
    for device in devices.values():
        stopping = device.options.stopping(limits)
        least = 0.0 if stopping is None else least_limit(device.options.force_noise(), stopping.averaged)
        if limits.force < least:
            table = source.get("limits")
            value = table.get("force") if isinstance(table, Map) else None
            message = f"the force of {device.name!r} is too noisy to hold a limit of {limits.force:g} N"
            hint = f"write {math.ceil(least)} N or more, and a lower limit at the nodes of a tree with a force sensor"
            yield (device if value is None else value).mark.error("out-of-bounds", message, hint)


def cell_names() -> list[str]:
    """Return the names of the shipped cells."""
    return sorted(path.stem for path in _shipped().glob("*.yaml"))


def cell_schema() -> dict[str, Any]:
    """Return the JSON Schema of cell files, with the options of every implementation, also of installed packages."""
    options = tuple(found.options for found in Implementations().all())
    devices = TypeAdapter(dict[str, Union[options]]).json_schema()  # type: ignore[valid-type]  # noqa: UP007
    schema = _CellFile.model_json_schema()
    definitions = {**schema.pop("$defs"), **devices.pop("$defs")}
    brought = {
        **schema["properties"]["devices"],
        "minProperties": 1,
    }  # only `check` knows the devices of an imported module
    listed = {**devices, "minProperties": 1}
    schema["properties"]["devices"] = {
        "description": listed.pop("description", "the devices, by name"),
        "type": "object",
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "if": {"required": ["imports"]},
        "then": {"properties": {"devices": brought}},
        "else": {"properties": {"devices": listed}},
        "$defs": definitions,
    }


def _shipped() -> Path:
    return Path(str(files("stretch_bt") / "trees" / "cells"))


def _calibrated(
    source: Map, root: Path, known: Implementations, found: list[Diagnostic]
) -> tuple[Map, HandFile | None]:
    """Return the file with the gripper's calibration from the one of the hand, where it names one, and that."""
    hand = source.get("hand")
    named = hand.get("calibration") if isinstance(hand, Map) else None
    if not (isinstance(hand, Map) and isinstance(named, Scalar)):
        return source, None
    if "plane_distance" in hand:
        told = "'plane_distance' is given, and in the calibration too"
        found.append(hand.key("plane_distance").mark.error("device-file", told, "leave one of them out"))
    try:
        text = load(root / named.text, str(root / named.text))
    except FileError as error:
        found += [_unread(named, first) if (first := error.diagnostics[0]).code in _NO_FILE else first]
        return source, None
    form = text.get("format")
    if not (isinstance(form, Scalar) and form.text == HAND_FORMAT):
        mark = text.mark if form is None else form.mark
        hint = f"write 'format: {HAND_FORMAT}' where it is one, or name the file that calibrate-hand wrote"
        found.append(mark.error("format-unknown", "this is no calibration of a hand", hint))
        return source, None
    try:
        made = validate(HandFile, text)
    except FileError as error:
        found += error.diagnostics
        return source, None
    gripper, devices = text.get("gripper"), source.get("devices")
    if gripper is None or not isinstance(devices, Map):
        return source, made
    pairs = tuple((key, _with_calibration(device, gripper, known)) for key, device in devices)
    whole = tuple((key, Map(pairs, devices.mark) if key.text == "devices" else value) for key, value in source)
    return Map(whole, source.mark), made


def _unread(named: Scalar, why: Diagnostic) -> Diagnostic:
    """Return a mistake at the name of a file that cannot be read."""
    if why.code == "file-missing":
        return named.mark.error(
            "file-missing", f"there is no file {named.text!r}", "write a path relative to the cell file"
        )
    return named.mark.error(
        why.code, f"{named.text!r}: {why.message}", "name the file that calibrate-hand wrote, relative to the cell file"
    )


def _with_calibration(device: Value, gripper: Value, known: Implementations) -> Value:
    """Return a device with the calibration of the hand, where it is a gripper that takes one and has none."""
    kind, use = (device.get(name) if isinstance(device, Map) else None for name in ("type", "use"))
    if (
        not (isinstance(device, Map) and isinstance(kind, Scalar) and isinstance(use, Scalar))
        or "calibration" in device
    ):
        return device
    if kind.text != "Gripper" or not _takes_calibration(known, use.text):
        return device
    return Map((*device.pairs, (Scalar("calibration", False, use.mark), gripper)), device.mark)


def _takes_calibration(known: Implementations, use: str) -> bool:
    try:
        found = known.find("Gripper", use)
    except Unusable:  # reported where the device is read
        return False
    return found is not None and "calibration" in found.options.model_fields
