"""Every implementation of a device that a cell file may name: shipped, of an installed package, or of a module that the file imports."""

from __future__ import annotations

import re
import sys
from abc import ABC
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from inspect import isabstract
from types import ModuleType
from typing import Any

from stretch_bt.blame import place_of
from stretch_bt.errors import InvalidInput, StretchError, named
from stretch_bt.forked import alone
from stretch_bt.hardware.driver import (
    ArmDriver,
    DepthCameraDriver,
    Driver,
    ForceSensorDriver,
    GripperDriver,
    OperatorDriver,
    Options,
)
from stretch_bt.hardware.polled import PolledDriver
from stretch_bt.hardware.typed_options import options_model

__all__ = [
    "GROUP",
    "SHIPPED",
    "Implementation",
    "Implementations",
    "Unusable",
    "driver_class",
    "drivers_in",
    "own_name",
]

#: entry points of installed packages: `use` in a cell file, and the driver class or a module that has it
GROUP = "stretch_bt.devices"

#: by kind and `use`; imported when a cell file names one
SHIPPED: dict[tuple[str, str], str] = {
    ("Arm", "simulated"): "stretch_bt.hardware.simulated.arm:SimulatedArm",
    ("Arm", "replay"): "stretch_bt.hardware.replay.arm:ReplayArm",
    ("Arm", "ur"): "stretch_bt.hardware.ur.arm:UrArm",
    ("Gripper", "simulated"): "stretch_bt.hardware.simulated.gripper:SimulatedGripper",
    ("Gripper", "robotiq"): "stretch_bt.hardware.robotiq.gripper:RobotiqGripper",
    ("Gripper", "robotiq_urcap"): "stretch_bt.hardware.robotiq.urcap_gripper:RobotiqUrcapGripper",
    ("DepthCamera", "simulated"): "stretch_bt.hardware.simulated.camera:SimulatedCamera",
    ("DepthCamera", "replay"): "stretch_bt.hardware.replay.camera:ReplayCamera",
    ("DepthCamera", "realsense"): "stretch_bt.hardware.realsense.camera:RealsenseCamera",
    ("ForceSensor", "simulated"): "stretch_bt.hardware.simulated.force_sensor:SimulatedForceSensor",
    ("ForceSensor", "replay"): "stretch_bt.hardware.replay.force_sensor:ReplayForceSensor",
    ("ForceSensor", "ati"): "stretch_bt.hardware.ati.force_sensor:AtiForceSensor",
    ("Operator", "simulated"): "stretch_bt.hardware.simulated.operator:SimulatedOperator",
    ("Operator", "console"): "stretch_bt.hardware.console.operator:ConsoleOperator",
}

_BASES: dict[str, type[Driver]] = {
    "Arm": ArmDriver,
    "Gripper": GripperDriver,
    "DepthCamera": DepthCameraDriver,
    "ForceSensor": ForceSensorDriver,
    "Operator": OperatorDriver,
}


class Unusable(StretchError):
    """A driver cannot be used; the text says why, `hint` what to do."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.hint = hint


@dataclass(frozen=True, slots=True)
class Implementation:
    """A driver class under the name that cell files have for it, and the model of its options there."""

    kind: str
    use: str
    cls: type[Driver]
    options: type[Options]

    @property
    def shipped(self) -> bool:
        """Whether it is part of this package."""
        return (self.kind, self.use) in SHIPPED

    @property
    def real(self) -> bool:
        """Whether there is something to connect to: no twin, no recording, no person."""
        return not self.cls.any_clock and self.kind != "Operator"


@dataclass(frozen=True)
class Implementations:
    """What one cell file may name: `own` are the driver classes of the modules that it imports."""

    own: list[type[Driver]] = field(default_factory=list)

    def names(self, kind: str) -> list[str]:
        """Return the names that `use` may take for a kind of device; nothing is imported, so the names of packages may be of another kind."""
        shipped = [use for k, use in SHIPPED if k == kind]
        own = [own_name(cls) for cls in self.own if _kind(cls) == kind]
        return list(dict.fromkeys([*shipped, *own, *(entry.name for entry in _entries())]))

    def all(self) -> Iterator[Implementation]:
        """Yield every implementation that can be used, the shipped ones first; of a package that is broken standard error has one line."""
        for kind, use in SHIPPED:
            yield _implementation(kind, use, driver_class(kind, use))
        for cls in self.own:
            yield _implementation(_kind(cls), own_name(cls), cls)
        broken: dict[str, Unusable] = {}
        for entry in _entries():
            try:
                yield from _of_package(entry)
            except Unusable as error:
                broken.setdefault(_package(entry), error)
        for one in broken.values():
            sys.stderr.write(f"warning: {one}; {one.hint}\n")

    def find(self, kind: str, use: str) -> Implementation | None:
        """Return the implementation of a kind of device that has this name, or None; raises Unusable for one that is broken."""
        shipped = (kind, use) in SHIPPED
        same = [cls for cls in self.own if shipped and (_kind(cls), own_name(cls)) == (kind, use)]
        if same:
            hint = f"set another name, as in use = 'my_{use}' in the class"
            raise Unusable(
                f"{same[0].__name__} of {same[0].__module__} has the name of a shipped {kind}, {use!r}", hint
            )
        found = [driver_class(kind, use)] if shipped else [cls for cls in self._named(use) if _kind(cls) == kind]
        if len(found) > 1:
            modules = " and ".join(sorted(cls.__module__ for cls in found))
            raise Unusable(f"two devices are called {use!r}, of {modules}", "uninstall or rename one of them")
        return _implementation(kind, use, found[0]) if found else None

    def kinds(self, use: str) -> list[str]:
        """Return the kinds of device that have this name."""
        return [k for k, name in SHIPPED if name == use] + [_kind(cls) for cls in self._named(use)]

    def _named(self, use: str) -> list[type[Driver]]:
        own = [cls for cls in self.own if own_name(cls) == use]
        return own or [cls for entry in _entries() if entry.name == use for cls in _loaded(entry)]


def driver_class(kind: str, use: str) -> type[Driver]:
    """Return the driver behind a shipped name."""
    module, _, name = SHIPPED[kind, use].partition(":")
    found: type[Driver] = getattr(import_module(module), name)
    return found


def drivers_in(brought: ModuleType | type) -> list[type[Driver]]:
    """Return the driver classes that a module, or its package, defines, or the one class; raises Unusable for one that is not whole."""
    top = (brought.__module__ if isinstance(brought, type) else brought.__name__).partition(".")[0]
    found = [brought] if isinstance(brought, type) else list(vars(brought).values())
    classes = [value for value in found if isinstance(value, type) and issubclass(value, Driver)]
    public = [cls for cls in classes if cls.__module__.partition(".")[0] == top and not cls.__name__.startswith("_")]
    own = list(dict.fromkeys(cls for cls in public if any(issubclass(cls, base) for base in _BASES.values())))
    return [_checked(cls) for cls in own if cls is brought or not _is_base(cls, own)]


def own_name(cls: type[Driver]) -> str:
    """Return the name that `use` takes for a class of an imported module."""
    return cls.use or re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", cls.__name__).lower()


def _kind(cls: type[Driver]) -> str:
    return next(kind for kind, base in _BASES.items() if issubclass(cls, base))


def _is_base(cls: type[Driver], own: Sequence[type[Driver]]) -> bool:
    """Return whether a class is abstract on purpose: it says so, or another one of its module derives from it."""
    derived = any(other is not cls and issubclass(other, cls) for other in own)
    return isabstract(cls) and (ABC in cls.__bases__ or derived)


def _unstoppable(cls: type[Driver]) -> list[str]:
    """Return what a driver lacks that moves something over its wire and could not stop it."""
    if not (issubclass(cls, PolledDriver) and issubclass(cls, ArmDriver | GripperDriver)):
        return []
    return ["halt"] if (cls.halt, cls.stop) == (PolledDriver.halt, PolledDriver.stop) else []


def _checked(cls: Any) -> type[Driver]:
    """Return a class that is a whole driver."""
    if not (isinstance(cls, type) and issubclass(cls, Driver) and any(issubclass(cls, b) for b in _BASES.values())):
        bases = ", ".join(base.__name__ for base in _BASES.values())
        what = getattr(cls, "__name__", repr(cls))
        raise Unusable(f"{what} is no driver", f"derive it from one of {bases} of stretch_bt.devices")
    missing = sorted({*getattr(cls, "__abstractmethods__", ()), *_unstoppable(cls)})
    if missing:
        raise Unusable(f"the driver {cls.__name__} lacks {', '.join(missing)}", "write what is missing")
    if not cls.__doc__:
        raise Unusable(f"the driver {cls.__name__} has no docstring", "write one sentence that says what it is")
    return cls


@cache
def _entries() -> tuple[EntryPoint, ...]:
    return tuple(sorted(entry_points(group=GROUP), key=lambda entry: entry.name))


@cache
def _loaded(entry: EntryPoint) -> list[type[Driver]]:
    """Return the driver that an entry point names, or the drivers of the module that it names."""
    package = _package(entry)
    try:
        with redirect_stdout(sys.stderr), alone():  # output is the command's alone
            found = entry.load()
    except (Exception, SystemExit) as error:  # whatever the module of a third party does
        at = place_of(error)
        raise Unusable(
            f"the device {entry.name!r} of the package {package} cannot be imported: {_line(error)}{at and f' ({at})'}",
            "install what it needs, or uninstall the package",
        ) from error
    classes = drivers_in(found) if isinstance(found, ModuleType) else [_checked(found)]
    if not classes:
        raise Unusable(f"the module {entry.value} of the package {package} has no driver", "name a driver class")
    return classes


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist is not None else entry.value


def _of_package(entry: EntryPoint) -> list[Implementation]:
    """Return the implementations behind an entry point, without any of a shipped name; raises Unusable, which names the package."""
    classes = [cls for cls in _loaded(entry) if (_kind(cls), entry.name) not in SHIPPED]
    try:
        made = [_implementation(_kind(cls), entry.name, cls) for cls in classes]
        for one in made:
            one.options.model_json_schema()
    except Unusable as error:
        raise Unusable(f"the device {entry.name!r} of the package {_package(entry)}: {error}", error.hint) from error
    except Exception as error:  # pydantic has no schema for the type of an option
        message = (
            f"the options of the device {entry.name!r} of the package {_package(entry)} have no schema: {_line(error)}"
        )
        raise Unusable(message, "give each a plain type") from error
    return made


def _line(error: BaseException) -> str:
    """Return an error and the first paragraph of its text, on one line."""
    return " ".join(named(error).partition("\n\n")[0].split())


def _implementation(kind: str, use: str, cls: type[Driver]) -> Implementation:
    try:
        return Implementation(kind, use, cls, options_model(cls, kind, use))
    except InvalidInput as error:
        message, _, hint = str(error).partition("; ")
        raise Unusable(message, hint) from error
    except Exception as error:  # pydantic has no schema for a type of an option
        raise Unusable(
            f"the options of {cls.__name__} cannot be read: {_line(error)}", "give each a plain type"
        ) from error
