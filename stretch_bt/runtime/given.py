"""Devices that the caller of `run` gave, and keeps: single ones, or an open cell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any, Protocol, runtime_checkable

from stretch_bt.clock import Clock, VirtualClock
from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.cell import Cell
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import Device
from stretch_bt.hardware.journal import Journal
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.monitored import Monitored, Watch

__all__ = ["Given"]


@runtime_checkable
class Telling(Protocol):
    """A device that tells a run of the commands it gets, as those of a cell do; a scripted one is."""

    def tell(self, name: str, journal: Journal) -> None:
        """Tell the journal from now on; `name` is what the tree calls the device."""
        ...


class Given:
    """Devices that the caller gave, and keeps, with what a run on them goes by.

    Parameters
    ----------
    devices
        By the names that the tree declares.
    cell
        The open cell that they are of, where the caller gave that.

    Raises
    ------
    InvalidInput
        They go by two clocks or by none, or are of two cells.
    """

    def __init__(self, devices: Mapping[str, Device], cell: Cell | None = None) -> None:
        self.devices = devices
        self.cell = cell
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

    @contextmanager
    def heard_by(self, journal: Journal) -> Iterator[None]:
        """Let a journal take note of what passes between nodes and devices while the block runs."""
        relays = {id(d.watch.journal): d.watch.journal for d in self.devices.values() if isinstance(d, Monitored)}
        with ExitStack() as stack:
            for relay in relays.values():
                stack.enter_context(relay.heard_by(journal))
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
        for device in self.devices.values():
            try:
                device.stop()
            except Exception as error:  # one that breaks must not keep the others moving
                errors.append(error)
        return errors

    def close(self) -> list[Exception]:
        """Leave them open."""
        return []


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
