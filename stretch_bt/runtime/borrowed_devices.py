"""Devices that the caller of a run gave and keeps: the devices of an open cell, or single ones."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable
from weakref import WeakSet

from stretch_bt.clock import Clock, VirtualClock
from stretch_bt.errors import DeviceFault, InvalidInput, NoAnswer
from stretch_bt.hardware.interfaces import Device, MotionState, Reading
from stretch_bt.hardware.journal import Journal
from stretch_bt.hardware.monitored import Monitored, Watch, arms_first

if TYPE_CHECKING:
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.hardware.hand import Hand
    from stretch_bt.hardware.limits import Limits
    from stretch_bt.source import Scalar

__all__ = ["BorrowedDevices", "Lender", "borrow", "lenders"]


@runtime_checkable
class Telling(Protocol):
    """A device that reports to a run its answers and commands, as the devices of a cell do; a scripted one is."""

    def tell(self, name: str, journal: Journal) -> None:
        """Report to the journal from now on; `name` is the name of the device in the tree."""
        ...


class Lender(Protocol):
    """An open cell, whose devices may be given one by one to a run."""

    @property
    def is_open(self) -> bool:
        """Whether it has devices."""
        ...

    @property
    def hand(self) -> Hand:
        """The hand of its devices."""
        ...

    def lend(self, devices: Mapping[str, Device]) -> BorrowedDevices:
        """Return some of its devices for a run, once all is done that an earlier tree left undone."""
        ...


#: the open cells of the process
lenders: WeakSet[Lender] = WeakSet()


def borrow(devices: Mapping[str, Device]) -> BorrowedDevices:
    """Return devices for a run, by the names that its tree declares; devices of an open cell come as the cell lends them.

    Raises
    ------
    InvalidInput
        They go by two clocks or by none, are of two cells, or one has two names, so that no record could say who moved it.
    """
    names = {id(device): name for name, device in devices.items()}
    for name, device in devices.items():
        if names[id(device)] != name:
            raise InvalidInput(
                f"{name!r} and {names[id(device)]!r} are one device; declare it once in the tree, and use that name in all nodes"
            )
    borrowed = BorrowedDevices(devices)
    lender = next((each for each in lenders if each.is_open and each.hand is borrowed.hand), None)
    return borrowed if lender is None else lender.lend(devices)


class BorrowedDevices:
    """Devices that the caller gave, and keeps, with what a run on them goes by.

    Parameters
    ----------
    devices
        Devices by the names that the tree declares.
    cell
        The cell that all of them are of, where that is known.
    scene
        Simulated scene, as the caller named it.
    seed
        Seed of everything random in a simulation, where the caller of the run has no say in it.
    calling
        What an open cell goes through around a run, given its runner.

    Raises
    ------
    InvalidInput
        They go by two clocks or by none, or are of two cells.
    """

    def __init__(
        self,
        devices: Mapping[str, Device],
        cell: Cell | None = None,
        *,
        scene: str | None = None,
        seed: int | None = None,
        calling: Callable[[Any], AbstractContextManager[Any]] = nullcontext,
    ) -> None:
        self.devices = devices
        #: around a run, given its runner: a signal that the cell hears ends a run in another thread too
        self.calling = calling
        self.cell = cell
        self.scene = scene
        self.seed = seed
        self._watches = {id(d.watch.hand): d.watch for d in devices.values() if isinstance(d, Monitored)}
        if len(self._watches) > 1:
            names = ", ".join(name for name, d in devices.items() if isinstance(d, Monitored))
            raise InvalidInput(
                f"the devices {names} are of more than one cell; write one cell file with all of them, and open that"
            )
        self.clock = _clock(devices)

    @property
    def _watch(self) -> Watch | None:
        return next(iter(self._watches.values()), None)

    @property
    def hand(self) -> Hand | None:
        """The hand of their cell; None where they are of none."""
        return None if self._watch is None else self._watch.hand

    @property
    def limits(self) -> Limits | None:
        """The limits of their cell; None where they are of none."""
        return None if self._watch is None else self._watch.limits

    @property
    def is_whole_cell(self) -> bool:
        """Whether they are all devices of the cell, under its own names."""
        return self.cell is not None and dict(self.devices) == dict[str, Any](self.cell.devices)

    @property
    def scene_params(self) -> Mapping[Scalar, Scalar]:
        """The params that the scene of their cell asks for, at their places."""
        scene = None if self._watch is None else self._watch.scene
        return {} if scene is None else scene.placed_params

    def silent(self, needed: Container[str]) -> list[str]:
        """Return which of the devices that a run needs report to no journal."""
        known = (Monitored, Telling)
        return [name for name, device in self.devices.items() if name in needed and not isinstance(device, known)]

    @contextmanager
    def heard_by(self, journal: Journal) -> Iterator[None]:
        """Let a journal take note of what passes between nodes and devices while the block runs, under the names that the tree has."""
        monitored = {name: d for name, d in self.devices.items() if isinstance(d, Monitored)}
        renamed = _Renamed(journal, {device.name: name for name, device in monitored.items()})
        relays = {id(d.watch.journal): d.watch.journal for d in monitored.values()}
        with ExitStack() as stack:
            for relay in relays.values():
                stack.enter_context(relay.heard_by(renamed))
            for name, device in self.devices.items():
                if isinstance(device, Telling):
                    device.tell(name, journal)
            yield

    def truth_of_simulated(self) -> dict[str, float]:
        """Return what the scene knows of what simulated devices of the cell measure; nothing of single devices."""
        return self.cell.truth_of_simulated() if self.cell is not None else {}

    def sketch(self) -> dict[str, list[tuple[float, float]]]:
        """Return lines that show the simulated object of the cell; none of single devices."""
        return self.cell.sketch() if self.cell is not None else {}

    def stats(self) -> list[dict[str, Any]]:
        """Return what the twin of the cell did; nothing of single devices."""
        return self.cell.stats() if self.cell is not None else []

    def stop(self) -> list[Exception]:
        """Stop every device."""
        errors: list[Exception] = []
        for device in arms_first(self.devices.values()):
            try:
                device.stop()
            except Exception as error:  # one that breaks must not keep the others moving
                errors.append(error)
        return errors

    def close(self) -> list[Exception]:
        """Leave them open."""
        return []


class _Renamed:
    """Passes everything on to a journal, with the names that a tree has for the devices of a cell."""

    def __init__(self, journal: Journal, names: Mapping[str, str]) -> None:
        self._journal = journal
        self._names = names

    def reading(self, device: str, name: str, reading: Reading[Any]) -> None:
        """Pass it on."""
        self._journal.reading(self._names.get(device, device), name, reading)

    def command(self, device: str, name: str, arguments: Mapping[str, Any], owner: str) -> None:
        """Pass it on."""
        self._journal.command(self._names.get(device, device), name, arguments, owner)

    def motion(self, device: str, owner: str, state: MotionState) -> None:
        """Pass it on."""
        self._journal.motion(self._names.get(device, device), owner, state)

    def fault(self, device: str, fault: DeviceFault) -> None:
        """Pass it on."""
        self._journal.fault(self._names.get(device, device), fault)

    def unanswered(self, device: str, none: NoAnswer) -> None:
        """Pass it on."""
        self._journal.unanswered(self._names.get(device, device), none)


def _clock(devices: Mapping[str, Device]) -> Clock:
    """Return the one clock of some devices; those that go by any are given it."""
    clocks: dict[int, Clock] = {}
    for name, device in devices.items():
        if hasattr(device, "go_by"):
            continue
        clock = device.watch.clock if isinstance(device, Monitored) else getattr(device, "clock", None)
        if clock is None:
            hint = "open its cell with stretch_bt.open_cell, or give it an attribute 'clock' of stretch_bt.clock"
            raise InvalidInput(f"device {name!r} ({type(device).__name__}) has no clock that a run can go by; {hint}")
        clocks[id(clock)] = clock
    if len(clocks) > 1:
        raise InvalidInput(
            f"the devices {', '.join(devices)} go by {len(clocks)} clocks; give all of them the same one"
        )
    clock = next(iter(clocks.values()), None) or VirtualClock()
    for device in devices.values():
        if hasattr(device, "go_by"):
            device.go_by(clock)
    return clock
