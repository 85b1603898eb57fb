"""The devices of a cell file: the implementation of each, and its options; every mistake at its place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stretch_bt.blame import place_of
from stretch_bt.errors import DeviceFault, Diagnostic, FileError, StretchError
from stretch_bt.errors import named as named_error
from stretch_bt.hardware.driver import CellContext, Driver, Options
from stretch_bt.hardware.implementations import Implementation, Implementations, Unusable, drivers_in, own_name
from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.hardware.own_modules import ModuleRefused, Modules
from stretch_bt.source import Map, Mark, Scalar, Value, did_you_mean, validate

__all__ = ["DeviceSpec", "imported", "read_devices"]


@dataclass(frozen=True, slots=True)
class DeviceSpec:
    """A device of a cell: its name, its implementation, the options of that, and where the file has it."""

    name: str
    implementation: Implementation
    options: Options
    mark: Mark

    @property
    def type(self) -> str:
        """The interface."""
        return self.implementation.kind

    @property
    def use(self) -> str:
        """What the file calls the implementation."""
        return self.implementation.use

    def driver(self, cell: CellContext) -> Driver:
        """Return the driver, which touches nothing until it is opened; raises DeviceFault where it cannot be made."""
        try:
            return self.implementation.cls(self.name, self.options.given(), cell)
        except StretchError:
            raise
        except Exception as error:  # of a driver of one's own
            at = place_of(error)
            raise DeviceFault(
                self.name, f"its driver broke as it was made ({named_error(error)}{at and f', {at}'})"
            ) from error


def imported(table: Value | None, path: Path, found: list[Diagnostic]) -> list[type[Driver]]:
    """Return the driver classes of the modules that a cell file imports, and write down which cannot be had."""
    drivers: list[type[Driver]] = []
    modules = Modules.beside(path, "cell file", "devices")
    for _, target in table if isinstance(table, Map) else ():
        if not isinstance(target, Scalar):
            continue
        try:
            brought = drivers_in(modules.bring(target.text, path))
        except (ModuleRefused, Unusable) as refused:
            found.append(target.mark.error("import", str(refused), refused.hint))
            continue
        if not brought:
            hint = "derive a class from ArmDriver, GripperDriver, DepthCameraDriver or ForceSensorDriver of stretch_bt.devices"
            found.append(target.mark.error("import", f"module {target.text!r} has no driver", hint))
        drivers += brought
    return list(dict.fromkeys(drivers))


def read_devices(source: Any, root: Path, known: Implementations, found: list[Diagnostic]) -> dict[str, DeviceSpec]:
    """Return the devices that are right, and write down what is wrong with the others."""
    specs = {}
    for key, value in source if isinstance(source, Map) else ():
        kind, use = (value.get(name) if isinstance(value, Map) else None for name in ("type", "use"))
        if isinstance(value, Map) and isinstance(kind, Scalar) and isinstance(use, Scalar):
            problems = [*_misnamed(key)]
            named = _implementation(kind, use, known, problems)
            options = None if named is None or problems else _read_options(named, value, root, problems)
            found += problems
            if named is not None and options is not None:
                specs[key.text] = DeviceSpec(key.text, named, options, key.mark)
    return specs


def _misnamed(key: Scalar) -> Iterator[Diagnostic]:
    if not key.text.isidentifier():
        yield key.mark.error("device-name", f"{key.text!r} is no name for a device", "use letters, digits and _")


def _implementation(
    kind: Scalar, use: Scalar, known: Implementations, problems: list[Diagnostic]
) -> Implementation | None:
    """Return the implementation that a device names, or note why there is none."""
    if kind.text not in INTERFACES:
        hint = did_you_mean(kind.text, INTERFACES)
        problems.append(kind.mark.error("device-type", f"there is no device type {kind.text!r}", hint))
        return None
    try:
        found = known.find(kind.text, use.text)
        kinds = [] if found is not None else known.kinds(use.text)
    except Unusable as broken:
        problems.append(use.mark.error("device-use", str(broken), broken.hint))
        return None
    if found is None:
        hint = (
            f"{use.text!r} is a {kinds[0]}; write 'type: {kinds[0]}'" if kinds else _nearest(kind.text, use.text, known)
        )
        problems.append(use.mark.error("device-use", f"there is no {kind.text} called {use.text!r}", hint))
    return found


def _nearest(kind: str, use: str, known: Implementations) -> str:
    names = known.names(kind)
    own = [name for name in names if any(name == own_name(cls) for cls in known.own)]
    return did_you_mean(use, names) or (f"this file imports {', '.join(own)}" if own else f"one of {', '.join(names)}")


def _read_options(named: Implementation, device: Map, root: Path, problems: list[Diagnostic]) -> Options | None:
    try:
        options = validate(named.options, device)
        mistakes = [(option, message, hint) for option, message, hint in options.mistakes(root)]
    except FileError as error:
        problems += error.diagnostics
        return None
    except Exception as error:  # of a driver of one's own
        at = place_of(error)
        message = f"the options of {named.use!r} broke: {named_error(error)}{at and f' ({at})'}"
        problems.append(device.mark.error("device-use", message, "mend the driver, or ask who wrote it"))
        return None
    for option, message, hint in mistakes:
        place = device.get(option)
        mark = place.mark if place is not None else device.mark
        problems.append(mark.error("device-file", message, hint))
    return None if problems else options
