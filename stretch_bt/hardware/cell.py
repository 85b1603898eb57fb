"""The cell of a run: its devices, opened and watched over."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from stretch_bt.clock import Clock, MixedClock, RealClock, VirtualClock
from stretch_bt.errors import (
    CellError,
    DeviceFault,
    Diagnostic,
    InvalidInput,
    LimitExceeded,
    NotReady,
    StaleReading,
    StretchError,
    named,
)
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.cell_file import CellSpec
from stretch_bt.hardware.driver import ArmDriver, CellContext, Driver, GripperDriver
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.journal import Journal, Relay
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.measured_by import measured_by
from stretch_bt.hardware.monitored import MONITORED, Monitored, Watch, arms_first
from stretch_bt.source import did_you_mean

if TYPE_CHECKING:
    from stretch_bt.hardware.simulated.twin import Twin
    from stretch_bt.simulation.scene import Scene

__all__ = ["Cell", "clock_of", "open_cell"]

T = TypeVar("T")


class Cell:
    """Devices by name, the hand they share, and in simulation the truth."""

    def __init__(self, spec: CellSpec, context: CellContext, devices: dict[str, Monitored[Any]]) -> None:
        self.spec = spec
        self.hand = context.hand
        self.devices = devices
        self._context = context

    @property
    def limits(self) -> Limits:
        """The limits that every device holds."""
        return self.spec.limits

    @property
    def scene(self) -> Scene | None:
        """What is simulated."""
        return self._context.scene

    @property
    def twin(self) -> Twin:
        """The simulated world behind the devices; raises InvalidInput where nothing is simulated."""
        return self._context.twin

    def truth(self) -> dict[str, float]:
        """Return what a perfect observer would report now, SI; empty where nothing is simulated.

        Raises
        ------
        NoEquilibrium
            The simulated hand stands where its scene has no answer.
        """
        return {} if self._context.scene is None else self._context.twin.truth()

    def truth_of_simulated(self) -> dict[str, float]:
        """Return `truth` without the quantities that a real device measures: a real device does not see the scene's object.

        Raises
        ------
        NoEquilibrium
            As `truth` does.
        """
        opened = [self.spec.devices[name] for name in self.devices]
        real = {device.type for device in opened if not device.implementation.cls.simulated}
        kinds = {device.type for device in opened}
        return {name: value for name, value in self.truth().items() if not measured_by(name, kinds) & real}

    def sketch(self) -> dict[str, list[tuple[float, float]]]:
        """Return lines, m, that show a simulated object which changes its shape for good, as it is now; else none."""
        if self._context.scene is None:
            return {}
        return self._context.twin.world.sketch(self._context.now())

    def stats(self) -> list[dict[str, Any]]:
        """Return what the twin did, with its count and CPU time; empty where nothing is simulated."""
        if self._context.scene is None:
            return []
        from stretch_bt.simulation.account import account

        return account(self._context.twin.world)

    def stop(self) -> list[StretchError]:
        """Stop every device, and return what went wrong on the way."""
        return self._each("stop")

    def close(self) -> list[StretchError]:
        """Stop and close every device, the last opened first, and return what went wrong on the way."""
        return self._each("close")

    def _each(self, action: str) -> list[StretchError]:
        errors: list[StretchError] = []
        devices = [*reversed(self.devices.values())]
        for device in arms_first(devices) if action == "stop" else devices:
            try:
                (device.stop if action == "stop" else device.close)()
            except StretchError as error:
                errors.append(error)
            except Exception as error:  # one device that breaks must not keep the others moving
                errors.append(StretchError(f"{device.name}: {action} broke ({named(error)})"))
        return errors


def open_cell(
    spec: CellSpec,
    *,
    now: Callable[[], float] | None = None,
    clock: Clock | None = None,
    seed: int = 0,
    scene: Scene | None = None,
    journal: Journal | None = None,
    only: Collection[str] | None = None,
    closing: Callable[[], AbstractContextManager[object]] = nullcontext,
) -> Cell:
    """Open the devices of a cell; moves nothing.

    Parameters
    ----------
    spec
        What `load_cell` returned.
    now
        The time, s, that ages, motions and recordings go by; by default the clock's.
    clock
        What a tree goes by that is run on these devices; see `clock_of`. Without one no tree can be.
    seed
        Seed of everything random in a simulation.
    scene
        What is simulated; needed when a device is.
    journal
        What takes note of readings, commands, motions and faults.
    only
        Names of the devices to open; all when None.
    closing
        Around the closing of those opened before one that does not open, so that no signal breaks it off.

    Raises
    ------
    DeviceFault
        A device does not open; those opened before it are closed again.
    """
    wanted = _wanted(spec, only)
    now = now or (clock or RealClock()).now
    mixed = clock if isinstance(clock, MixedClock) else None
    real = now if mixed is None else mixed.machine.now
    hand, relay = Hand(spec.hand), Relay(*([] if journal is None else [journal]))
    classes = {name: spec.devices[name].implementation.cls for name in wanted}
    if scene is None and any(cls.simulated for cls in classes.values()):
        raise InvalidInput(f"the cell {spec.name!r} is simulated and needs a scene; name one with --scene")
    contexts = {
        any_clock: CellContext(time, seed, spec.path.parent, hand, spec.limits, scene)
        for any_clock, time in ((True, now), (False, real))
    }
    stamps = {True: None, False: None if mixed is None else mixed.of_machine}
    watches = {
        of: Watch(context.now, spec.limits, hand, relay, clock, stamps[of], scene) for of, context in contexts.items()
    }
    devices = {
        name: MONITORED[spec.devices[name].type](
            name, spec.devices[name].driver(contexts[cls.any_clock]), watches[cls.any_clock]
        )
        for name, cls in classes.items()
    }
    cell = Cell(spec, contexts[True], devices)
    try:
        for device in devices.values():
            device.open()
        _follow(cell, classes)
    except BaseException:
        with closing():
            cell.close()
        raise
    return cell


def clock_of(spec: CellSpec, only: Collection[str] | None = None) -> Clock:
    """Return a clock for devices of a cell, `only` those named or all: one that goes as fast as is computed where none is real, the machine's
    where all are, and one that stands still in a tick where some are.

    Raises
    ------
    CellError
        The cell has no device of a name in `only`.
    """
    free = {spec.devices[name].implementation.cls.any_clock for name in _wanted(spec, only)}
    if False not in free:
        return VirtualClock()
    return MixedClock() if True in free else RealClock()


def _follow(cell: Cell, classes: Mapping[str, type[Driver]]) -> None:
    """Let the hand of a simulation be where a real arm has it, and its fingers where a real gripper has them."""
    if not any(cls.simulated for cls in classes.values()):
        return
    twin = cell.twin
    for name, cls in classes.items():
        device = cell.devices[name]
        if issubclass(cls, ArmDriver) and not cls.simulated:
            twin.follow_arm(partial(_newest, device, "pose", device.driver.pose))
        elif issubclass(cls, GripperDriver) and not cls.simulated:
            twin.follow_gripper(partial(_newest, device, "opening", device.driver.opening))


def _newest(device: Monitored[Any], what: str, read: Callable[[], Reading[T]]) -> Reading[T]:
    """Read a device for the simulation beside it, past the journal: no node asked. Raises StaleReading."""
    try:
        reading, age = device.fresh(what, read, PLACE)
    except (StaleReading, LimitExceeded, NotReady):
        raise
    except DeviceFault as fault:  # of this device, not of the simulated one that is read
        device.keep(fault)
        raise
    if age > PLACE:
        raise StaleReading(
            device.name, f"its latest {what} is {age:.3g} s old; the simulation beside it needs a newer one"
        )
    return reading


def _wanted(spec: CellSpec, only: Collection[str] | None) -> list[str]:
    unknown = [name for name in only or () if name not in spec.devices]
    if unknown:
        hints = {name: did_you_mean(name, spec.devices) for name in unknown}
        message = "the cell has no device {!r}"
        raise CellError(
            [Diagnostic(str(spec.path), 1, 1, "error", "device-missing", message.format(n), hints[n]) for n in unknown]
        )
    return [name for name in spec.devices if only is None or name in only]
