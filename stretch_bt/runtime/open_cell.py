"""A cell that stays open, for scripts and notebooks: nodes and library subtrees are ticked one call at a time."""

from __future__ import annotations

import atexit
from collections.abc import Collection, Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from py_trees.common import Status

from stretch_bt.clock import Clock, VirtualClock
from stretch_bt.errors import DeviceFault, InvalidInput, StretchError, writable
from stretch_bt.hardware.cell import Cell, clock_of
from stretch_bt.hardware.cell import open_cell as open_devices
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.limits import Limits
from stretch_bt.runtime.between_calls import BetweenCalls
from stretch_bt.runtime.context import RunContext, Seen
from stretch_bt.runtime.do import Do
from stretch_bt.runtime.given import Given
from stretch_bt.runtime.load_ahead import load_ahead, load_first
from stretch_bt.runtime.owed import Owed, worst_of
from stretch_bt.runtime.signals import unbroken
from stretch_bt.threads import one_thread

if TYPE_CHECKING:
    import py_trees

    from stretch_bt.runtime.record import RunRecord
    from stretch_bt.runtime.subtree import Subtree

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
        Of everything random in a simulation.
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
        spec = load_cell(cell)
        world = None
        if spec.simulated:
            if scene is None:
                raise InvalidInput(
                    f"the cell {spec.name!r} is simulated and needs a scene, as in scene='water_balloon'"
                )
            from stretch_bt.simulation.scene import load_scene

            world = load_scene(str(scene))
        self.scene = None if scene is None else str(scene)
        self.seed = seed
        self.clock: Clock = clock_of(spec)
        #: the latest record of each name that a call gave
        self.records: dict[str, Any] = {}
        self._ticks = 0
        self._load(sheet=world is not None and world.is_sheet)
        self._record = self._begun(out, spec.path.name)
        self._seen = Seen(self._record, self.clock.now)
        self._cell: Cell | None = None
        self.do = Do(self)
        #: subtrees that have begun and not ended
        self.live: list[Subtree] = []
        #: what interrupted subtrees of this cell have still to do
        self.owed = Owed(self.clock, self.begin_tick, self._stop_devices)
        self.between = BetweenCalls(self._stop_devices, virtual=isinstance(self.clock, VirtualClock))
        atexit.register(self.close)
        try:
            self._cell = open_devices(
                spec, clock=self.clock, seed=seed, scene=world, journal=self._seen, only=only, closing=unbroken
            )
            self.between.listen()
        except BaseException as error:
            self.close()
            self._end_record("FAULT" if isinstance(error, DeviceFault) else "ERROR", writable(error))
            raise

    def _load(self, *, sheet: bool) -> None:
        if isinstance(self.clock, VirtualClock):
            load_first(sheet=sheet)
        else:
            load_ahead()

    def _begun(self, out: str | Path | None, cell: str) -> RunRecord | None:
        """Return the record of the calls, begun, where one is asked for."""
        if out is None:
            return None
        from stretch_bt.runtime.prepare import versions
        from stretch_bt.runtime.record import RunRecord

        record = RunRecord(Path(out))
        scene = Path(self.scene).name if self.scene else None
        header: dict[str, Any] = {
            "tree": None,
            "calls": True,
            "seed": self.seed,
            "scene": scene,
            "cell": cell,
            "keys": {},
        }
        record.start({**header, "versions": versions("stretch-bt", "py_trees", "numpy")}, {"tree": None, **header})
        return record

    # --- what it is

    @property
    def cell(self) -> Cell:
        """The devices as one; raises InvalidInput once it is closed."""
        if self._cell is None:
            raise InvalidInput("this cell is closed; open it again with stretch_bt.open_cell")
        return self._cell

    @property
    def devices(self) -> Mapping[str, Any]:
        """The devices by their names."""
        self.between.listen()
        return self.cell.devices

    @property
    def hand(self) -> Hand:
        """The hand: its geometry, and the height of first contact once a call has found it."""
        return self.cell.hand

    @property
    def limits(self) -> Limits:
        """The limits of the cell, which hold for every call."""
        return self.cell.limits

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

        Raises what broke on the way once all is closed, a DeviceFault before anything else.
        """
        errors: list[BaseException] = []
        with unbroken():
            if self._cell is not None:
                errors = self._closed(self._cell)
            atexit.unregister(self.close)
        self.between.end()
        if errors:
            raise worst_of(errors)

    def _closed(self, cell: Cell) -> list[BaseException]:
        """Close, whatever breaks, and return what did."""
        errors: list[BaseException] = []

        def settle() -> None:
            for subtree in list(self.live):
                subtree.stop(Status.INVALID)
            with one_thread():
                self.owed.settle()

        for step in (settle, lambda: errors.extend(self.owed.take_errors()), lambda: errors.extend(cell.close())):
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
            self._record.close({"status": status, "reason": reason, "outputs": {}})

    def _stop_devices(self) -> list[StretchError]:
        return [] if self._cell is None else self._cell.stop()

    def attend(self, behaviour_tree: py_trees.trees.BehaviourTree) -> None:
        """Let a behaviour tree tick, before each of its own ticks, the `finally` that interrupted subtrees of this cell owe."""
        behaviour_tree.add_pre_tick_handler(self.owed.attend)
        behaviour_tree.add_post_tick_handler(self.owed.leave)

    def new_context(self) -> RunContext:
        """Return the context of a tree on this cell: its hand, limits and devices."""
        context = RunContext(self.hand)
        context.limits, context.devices = self.limits, self.devices
        context.folder = None if self._record is None else self._record.folder
        return context

    def begin_tick(self, context: RunContext) -> None:
        """Begin a tick of a tree that somebody else ticks."""
        self._ticks += 1
        context.ticks, context.now = context.ticks + 1, self.clock.now()
        if self._record is not None:
            self._record.begin_tick(self._ticks, context.now)

    def given(self) -> Given:
        """Return the devices as a call takes them, once nothing is owed."""
        self.between.settle()
        with one_thread():
            self.owed.settle()
        errors = self.owed.take_errors()
        if errors:
            self._stop_devices()
            raise worst_of(errors)
        return Given(self.devices, self.cell)

    def given_to_run(self) -> Given:
        """Return the devices as a whole task takes them, which leaves no record of earlier calls true."""
        given = self.given()
        self.records.clear()
        return given
