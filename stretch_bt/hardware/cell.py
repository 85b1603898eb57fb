"""The cell of a run: its devices, opened and watched over."""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from stretch_bt.errors import CellError, Diagnostic, InvalidInput, StretchError, named
from stretch_bt.hardware.cell_file import CellSpec
from stretch_bt.hardware.driver import Bench
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.journal import Journal, NoJournal
from stretch_bt.hardware.monitored import MONITORED, Monitored, Watch
from stretch_bt.source import did_you_mean

if TYPE_CHECKING:
    from stretch_bt.simulation.scene import Scene

__all__ = ["Cell", "open_cell"]


class Cell:
    """Devices by name, the hand they share, and in simulation the truth."""

    def __init__(self, spec: CellSpec, bench: Bench, devices: dict[str, Monitored[Any]]) -> None:
        self.spec = spec
        self.hand = bench.hand
        self.devices = devices
        self._bench = bench

    def truth(self) -> dict[str, float]:
        """Return what a perfect observer would report now, SI; empty where nothing is simulated.

        Raises
        ------
        NoEquilibrium
            The simulated hand stands where its scene has no answer.
        """
        return {} if self._bench.scene is None else self._bench.twin.truth()

    def sketch(self) -> dict[str, list[tuple[float, float]]]:
        """Return lines, m, that show a simulated object which changes its shape for good, as it is now; else none."""
        if self._bench.scene is None:
            return {}
        return self._bench.twin.world.sketch(self._bench.now())

    def stats(self) -> list[dict[str, Any]]:
        """Return what the twin did, how often and in what CPU time; empty where nothing is simulated."""
        if self._bench.scene is None:
            return []
        from stretch_bt.simulation.account import account

        return account(self._bench.twin.world)

    def stop(self) -> list[StretchError]:
        """Stop every device, and return what went wrong on the way."""
        return self._each("stop")

    def close(self) -> list[StretchError]:
        """Stop and close every device, the last opened first, and return what went wrong on the way."""
        return self._each("close")

    def _each(self, action: str) -> list[StretchError]:
        errors: list[StretchError] = []
        for device in reversed(self.devices.values()):
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
    now: Callable[[], float],
    seed: int = 0,
    scene: Scene | None = None,
    journal: Journal | None = None,
    only: Collection[str] | None = None,
    closing: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> Cell:
    """Open the devices of a cell; moves nothing.

    Parameters
    ----------
    spec
        What `load_cell` returned.
    now
        The clock, s, that ages, motions and recordings go by.
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
    bench = Bench(now, seed, spec.path.parent, Hand(spec.hand), spec.limits, scene)
    if scene is None and any(spec.devices[name].implementation.cls.simulated for name in wanted):
        raise InvalidInput(f"the cell {spec.name!r} is simulated and needs a scene; name one with --scene")
    watch = Watch(now, spec.limits, bench.hand, journal or NoJournal())
    devices = {
        name: MONITORED[spec.devices[name].type](name, spec.devices[name].driver(bench), watch) for name in wanted
    }
    cell = Cell(spec, bench, devices)
    try:
        for device in devices.values():
            device.open()
    except BaseException:
        with closing():
            cell.close()
        raise
    return cell


def _wanted(spec: CellSpec, only: Collection[str] | None) -> list[str]:
    unknown = [name for name in only or () if name not in spec.devices]
    if unknown:
        hints = {name: did_you_mean(name, spec.devices) for name in unknown}
        message = "the cell has no device {!r}"
        raise CellError(
            [Diagnostic(str(spec.path), 1, 1, "error", "device-missing", message.format(n), hints[n]) for n in unknown]
        )
    return [name for name in spec.devices if only is None or name in only]
