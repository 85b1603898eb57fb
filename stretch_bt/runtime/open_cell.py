"""A cell that stays open, for scripts and notebooks: nodes and library subtrees are ticked one call at a time."""

from __future__ import annotations

import atexit
from collections.abc import Collection, Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from py_trees.common import Status

from stretch_bt.arguments import check_arguments, checked_seed
from stretch_bt.clock import Clock, VirtualClock
from stretch_bt.errors import DeviceFault, InvalidInput, StretchError, writable
from stretch_bt.hardware.cell import Cell, clock_of
from stretch_bt.hardware.cell import open_cell as open_devices
from stretch_bt.hardware.cell_file import CellSpec, load_cell
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import Device
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.monitored import Monitored
from stretch_bt.runtime.between_calls import BetweenCalls
from stretch_bt.runtime.borrowed_devices import BorrowedDevices, lenders
from stretch_bt.runtime.calls_record import record_of_calls
from stretch_bt.runtime.context import RunContext, Seen
from stretch_bt.runtime.do import Do
from stretch_bt.runtime.load_ahead import load_ahead, load_first
from stretch_bt.runtime.pending_finally import PendingFinally, worst_of
from stretch_bt.runtime.signals import signals, unbroken
from stretch_bt.runtime.tick_grid import TickGrid
from stretch_bt.threads import one_thread
from stretch_bt.tree.document import TICK

if TYPE_CHECKING:
    import py_trees

    from stretch_bt.runtime.subtree import Subtree
    from stretch_bt.simulation.scene import Scene

__all__ = ["OpenCell", "open_cell"]


def open_cell(
    cell: str | Path = "simulated",
    *,
    scene: str | Path | None = None,
    seed: int = 0,
    only: Collection[str] | None = None,
    out: str | Path | None = None,
) -> OpenCell:
    """Open the devices of a cell for a script or a notebook; moves nothing. Close it by `with`, or by `.close()`.

    Parameters
    ----------
    cell
        A cell file, or the name of a shipped cell.
    scene
        What is simulated, where a device is: a scene file, or the name of a shipped scene.
    seed
        Seed of everything random in a simulation.
    only
        Names of the devices to open; all by default.
    out
        Folder of a record of all calls, which must be empty or absent; none by default.

    Raises
    ------
    CellError, SceneError
        A file is wrong.
    DeviceFault
        A device does not open; those opened before it are closed again.
    """
    return OpenCell(cell, scene=scene, seed=seed, only=only, out=out)


def _scene_of(spec: CellSpec, scene: str | Path | None) -> Scene | None:
    """Return the scene that a cell simulates, None where it simulates nothing; raises InvalidInput where none is named."""
    if not spec.simulated:
        return None
    if scene is None:
        raise InvalidInput(f"the cell {spec.name!r} is simulated and needs a scene, as in scene='water_balloon'")
    from stretch_bt.simulation.scene import load_scene

    return load_scene(str(scene))


def _load_modules(spec: CellSpec, world: Scene | None, clock: Clock) -> None:
    """Import what calls would import as they tick."""
    if isinstance(clock, VirtualClock):
        load_first(sheet=world is not None and world.is_sheet)
    else:
        load_ahead(device.type for device in spec.devices.values())


class OpenCell:
    """Devices of a cell, and what was found with them so far.

    Devices are attributes by their names, and in `devices`. `do` ticks a node or a library subtree; records that it gives are
    kept, and go to later calls that leave them out. In virtual time the clock goes on only while something is ticked.
    """

    def __init__(
        self,
        cell: str | Path,
        *,
        scene: str | Path | None,
        seed: int,
        only: Collection[str] | None,
        out: str | Path | None,
    ) -> None:
        check_arguments(cell=cell, scene=scene, out=out)
        spec = load_cell(cell)
        world = _scene_of(spec, scene)
        self.scene = None if scene is None else str(scene)
        self.seed = seed = checked_seed(seed)
        self.clock: Clock = clock_of(spec)
        #: the latest record of each name that a call gave
        self.records: dict[str, Any] = {}
        #: grid of the ticks of all calls
        self.grid = TickGrid(TICK)
        _load_modules(spec, world, self.clock)
        self._record = None if out is None else record_of_calls(Path(out), spec, scene=self.scene, seed=seed)
        self._seen = Seen(self._record, self.clock.now)
        self._cell: Cell | None = None
        self.do = Do(self)
        #: subtrees that have begun and not ended
        self.live: list[Subtree] = []
        #: each `finally` that interrupted subtrees of this cell have still to run
        self.pending_finally = PendingFinally(self.clock, self.begin_tick, self._stop_devices)
        self.between = BetweenCalls(self._stop_devices, virtual=isinstance(self.clock, VirtualClock))
        self._open(spec, world, only)

    def _open(self, spec: CellSpec, world: Scene | None, only: Collection[str] | None) -> None:
        atexit.register(self.close)
        try:
            self._cell = open_devices(
                spec, clock=self.clock, seed=self.seed, scene=world, journal=self._seen, only=only, closing=unbroken
            )
            self.between.listen()
            lenders.add(self)
        except BaseException as error:
            self.close()
            self._end_record("FAULT" if isinstance(error, DeviceFault) else "ERROR", writable(error))
            raise

    # --- what it is

    @property
    def cell(self) -> Cell:
        """The devices as one; raises InvalidInput once it is closed."""
        if self._cell is None:
            raise InvalidInput("this cell is closed; open it again with stretch_bt.open_cell")
        return self._cell

    @property
    def is_open(self) -> bool:
        """Whether it has devices."""
        return self._cell is not None

    @property
    def devices(self) -> Mapping[str, Any]:
        """The devices by their names."""
        cell = self.cell
        self.between.listen()
        return cell.devices

    @property
    def hand(self) -> Hand:
        """The hand: its geometry, and the height of first contact once a call has found it."""
        return self.cell.hand

    @property
    def limits(self) -> Limits:
        """The limits of the cell, which hold for every call."""
        return self.cell.limits

    @property
    def ticks(self) -> int:
        """How many ticks there were: as many as of a task with these calls one after the other."""
        return self.grid.ticks

    @property
    def commands(self) -> list[Any]:
        """The commands that calls gave to the devices, the latest 10,000."""
        return list(self._seen.commands)

    def truth(self) -> dict[str, float]:
        """Return what a perfect observer would report now, SI; empty where nothing is simulated."""
        return self.cell.truth()

    def __getattr__(self, name: str) -> Any:
        cell = self.__dict__.get("_cell")
        if cell is not None and name in cell.devices:
            self.between.listen()
            return cell.devices[name]
        known = ", ".join(cell.devices) if cell is not None else "none while it is closed"
        raise AttributeError(f"an open cell has no {name!r}; its devices: {known}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(self._cell.devices if self._cell is not None else ())]

    def __repr__(self) -> str:
        if self._cell is None:
            return "<a closed cell>"
        scene = f" on {self.scene}" if self.scene else ""
        return f"<open cell {self._cell.spec.name!r}{scene}: {', '.join(self._cell.devices)}; {self.clock.now():.2f} s>"

    # --- its end

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Do what is owed, then stop and close every device; may be called more than once.

        Raises the worst error on the way once all is closed, a DeviceFault before anything else.
        """
        try:
            with unbroken() as errors:
                if self._cell is not None:
                    errors += self._closed(self._cell)
                atexit.unregister(self.close)
        finally:
            self.between.end()
        if errors:
            raise worst_of(errors)

    def _closed(self, cell: Cell) -> list[BaseException]:
        """Close, whatever breaks, and return what did."""
        errors: list[BaseException] = []

        def settle() -> None:
            for subtree in list(self.live):
                subtree.stop(Status.INVALID)
            with one_thread(), signals(self.pending_finally.cut_short):
                self.pending_finally.settle()

        for step in (
            settle,
            lambda: errors.extend(self.pending_finally.take_errors()),
            lambda: errors.extend(cell.close()),
        ):
            try:
                step()
            except BaseException as error:
                errors.append(error)
        self._cell = None
        try:
            self._end_record("ERROR" if errors else "SUCCESS", "; ".join(map(writable, errors)))
        except StretchError as error:
            errors.append(error)
        return errors

    def _end_record(self, status: str, reason: str) -> None:
        if self._record is not None:
            counts = {"ticks": self.ticks, "task_seconds": self.clock.now()}
            self._record.close({"status": status, "reason": reason, "outputs": {}, **counts})

    def _stop_devices(self) -> list[StretchError]:
        return [] if self._cell is None else self._cell.stop()

    def attend(self, behaviour_tree: py_trees.trees.BehaviourTree) -> None:
        """Let a behaviour tree tick, before each of its own ticks, the `finally` that interrupted subtrees of this cell owe."""
        behaviour_tree.add_pre_tick_handler(self.pending_finally.attend)
        behaviour_tree.add_post_tick_handler(self.pending_finally.leave)

    def new_context(self) -> RunContext:
        """Return the context of a tree on this cell: its hand, limits and devices."""
        context = RunContext(self.hand)
        context.limits, context.devices = self.limits, self.devices
        context.folder = None if self._record is None else self._record.folder
        return context

    def begin_tick(self, context: RunContext) -> None:
        """Begin a tick of a tree that somebody else ticks."""
        self.grid.ticks += 1
        context.ticks, context.now = context.ticks + 1, self.clock.now()
        if self._record is not None:
            self._record.begin_tick(self.grid.ticks, context.now)

    def settle(self) -> None:
        """Do what an earlier signal or an interrupted subtree left undone, before anything begins; raises the worst error of that.

        A subtree that has come to its `finally` is interrupted: the next one to begin would else take the devices from it.
        """
        self.between.settle()
        with one_thread():
            for subtree in [each for each in self.live if each.is_ending]:
                subtree.stop(Status.INVALID)
            self.pending_finally.settle()
        errors = self.pending_finally.take_errors()
        if errors:
            raise worst_of([*errors, *self._stop_devices()])

    def lend(self, devices: Mapping[str, Device] | None = None) -> BorrowedDevices:
        """Return the devices, or some of them and others, for a whole task, which leaves no record of earlier calls true."""
        self.settle()
        self.records.clear()
        given = self.devices if devices is None else devices
        own = all(isinstance(device, Monitored) for device in given.values())
        cell = self.cell if own else None
        return BorrowedDevices(given, cell, scene=self.scene, seed=self.seed, calling=self.between.calling)
