"""A cell that stays open, for scripts and notebooks: nodes and library subtrees are ticked one call at a time."""

from __future__ import annotations

import atexit
import inspect
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from stretch_bt.clock import Clock, VirtualClock
from stretch_bt.errors import DeviceFault, InvalidInput, NodeError, Refused, StretchError, writable
from stretch_bt.hardware.cell import Cell, clock_of
from stretch_bt.hardware.cell import open_cell as open_devices
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.limits import Limits
from stretch_bt.runtime.between_calls import BetweenCalls
from stretch_bt.runtime.context import RunContext, Seen
from stretch_bt.runtime.given import Given
from stretch_bt.runtime.load_ahead import load_ahead, load_first
from stretch_bt.runtime.one_call import MODIFIERS, OneCall, called, names
from stretch_bt.runtime.outputs import Outputs
from stretch_bt.runtime.owed import Owed
from stretch_bt.runtime.runner import LONGEST, Outcome, Runner
from stretch_bt.runtime.signals import unbroken
from stretch_bt.threads import one_thread
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.build import BuiltTree, build
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.cell import Cell as Slot
from stretch_bt.units import Estimate

if TYPE_CHECKING:
    import py_trees

    from stretch_bt.runtime.record import RunRecord

__all__ = ["Do", "OpenCell", "open_cell"]


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
        self._memory: dict[Any, Any] = {}
        self._ticks = 0
        self._load(sheet=world is not None and world.fidelity == "sheet")
        self._record = self._begun(out, spec.path.name)
        self._seen = Seen(self._record, self.clock.now)
        self._cell: Cell | None = None
        try:
            self._cell = open_devices(
                spec, clock=self.clock, seed=seed, scene=world, journal=self._seen, only=only, closing=unbroken
            )
        except BaseException as error:
            self._end_record("FAULT" if isinstance(error, DeviceFault) else "ERROR", writable(error))
            raise
        self.do = Do(self)
        #: what interrupted subtrees of this cell have still to do
        self.owed = Owed(self.clock, self.begin_tick)
        self._between = BetweenCalls(self._stop_devices, virtual=isinstance(self.clock, VirtualClock))
        self._between.begin()
        atexit.register(self.close)

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
        """Stop and close every device; may be called more than once. Raises the first DeviceFault on the way, once all are closed."""
        cell, self._cell = self._cell, None
        if cell is None:
            return
        atexit.unregister(self.close)
        with unbroken():
            errors = self._close(cell)
            self._end_record("ERROR" if errors else "SUCCESS", "; ".join(map(writable, errors)))
        self._between.end()
        if errors:
            raise errors[0]

    def _end_record(self, status: str, reason: str) -> None:
        if self._record is not None:
            self._record.close({"status": status, "reason": reason, "outputs": {}})

    def _close(self, cell: Cell) -> list[BaseException]:
        """Do what is owed, then stop and close every device; return what broke."""
        self._cell = cell
        try:
            with one_thread():
                self.owed.settle()
        finally:
            self._cell = None
            errors = [*self.owed.take_errors(), *cell.close()]
        return errors

    def _stop_devices(self) -> None:
        if self._cell is not None:
            self._cell.stop()

    def attend(self, behaviour_tree: py_trees.trees.BehaviourTree) -> None:
        """Let a behaviour tree tick, before each of its own ticks, the `finally` that interrupted subtrees of this cell owe."""
        self.owed.attended = True
        behaviour_tree.add_pre_tick_handler(self.owed.tick)

    def new_context(self) -> RunContext:
        """Return the context of a tree on this cell: its hand, limits and devices."""
        context = RunContext(self.hand)
        context.limits, context.devices = self.limits, self.devices
        context.memory = self._memory
        context.folder = None if self._record is None else self._record.folder
        return context

    def begin_tick(self, context: RunContext) -> None:
        """Begin a tick of a tree that somebody else ticks."""
        self._ticks += 1
        context.ticks, context.now = context.ticks + 1, self.clock.now()
        if self._record is not None:
            self._record.begin_tick(self._ticks, context.now)

    def given(self) -> Given:
        """Return the devices as a run takes them, once nothing is owed."""
        self._between.settle()
        self.owed.settle()
        errors = self.owed.take_errors()
        if errors:
            raise errors[0]
        return Given(self.devices, self.cell)


class Do:
    """Ticks a node or a library subtree of an open cell to its end: `do("press", depth="5 mm")`, or `do.press(depth=0.005)`.

    Ports take SI numbers, text with a unit, and records; `timeout` and `guard` are as in a tree file. A record that is left
    out is the latest that a call gave under its name. The outputs come back as attributes, a number with its standard
    deviation as `.sd`.

    Raises
    ------
    InvalidInput
        A name or a value is wrong; nothing has moved.
    Refused
        It ended with FAILURE; its reason says why. The records that it would have given are unset.
    DeviceFault
        A device failed; every device is stopped.
    KeyboardInterrupt
        A signal came; every device is stopped.
    """

    def __init__(self, cell: OpenCell) -> None:
        self._open = cell

    def __call__(self, name: str, /, **ports: Any) -> Outputs:
        """Tick it to its end."""
        cell = self._open
        kinds = {device: spec.type for device, spec in cell.cell.spec.devices.items() if device in cell.devices}
        call = OneCall(called(name), ports, cell.records, kinds)
        with one_thread():
            return _Ticked(cell, call).outputs()

    def __dir__(self) -> list[str]:
        return names()

    def __getattr__(self, name: str) -> Callable[..., Outputs]:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            target = called(name)
        except InvalidInput as error:
            raise AttributeError(str(error)) from None
        bound = partial(self, name)
        bound.__doc__ = target.doc
        keyword = inspect.Parameter.KEYWORD_ONLY
        words = (*target.ports, *target.devices, *MODIFIERS)
        bound.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
            [
                inspect.Parameter(word, keyword, default=None, annotation=str(target.ports.get(word, "str")))
                for word in words
            ]
        )
        return bound

    def __repr__(self) -> str:
        return f"<do of {self._open!r}>"


class _Quiet:
    """What the runner of a call stops at its end: nothing where the call ended well, for its nodes have ended their own motions."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.outcome = Outcome()

    def stop(self) -> list[StretchError]:
        """Stop every device after any other end."""
        return [] if self.outcome.status == "SUCCESS" else self.cell.stop()


class _Ticked:
    """One call, ticked to its end."""

    def __init__(self, cell: OpenCell, call: OneCall) -> None:
        self.cell, self.call = cell, call
        given = cell.given()
        context = cell.new_context()
        context.ticks = cell._ticks
        self.built: BuiltTree = build(call.program, context)
        self._check_devices()
        for slot in self._slots():
            name = slot.name.rpartition("/")[2]
            if name in call.values:
                slot.write(call.values[name])
        for node in self.built.nodes.values():
            if isinstance(node, Behavior):
                node.prepare()
        quiet = _Quiet(cell.cell)
        self.runner = Runner(
            self.built,
            context,
            given.clock,
            period=call.program.document.tick_period,
            cell=quiet,
            watchers=[] if cell._record is None else [cell._record],
            longest=LONGEST if isinstance(given.clock, VirtualClock) else float("inf"),
        )
        quiet.outcome = self.runner.outcome
        with cell._between.calling():
            self.outcome = self.runner.run()
        cell._ticks = context.ticks

    def _check_devices(self) -> None:
        missing = sorted(self.built.needed() - self.cell.devices.keys())
        if missing:
            raise InvalidInput(f"{self.call.target.name} needs {', '.join(missing)}, which this cell has not open")

    def _slots(self) -> Iterator[Slot]:
        depth = self.call.program.entry.count("/") + 1
        return (slot for slot in self.built.cells if slot.name.count("/") == depth)

    def outputs(self) -> Outputs:
        """Return what the call gave; raises what it ended with."""
        written = (*self.call.target.outs, *self.call.target.inouts)
        held = {slot.name.rpartition("/")[2]: slot for slot in self._slots()}
        good = self.outcome.status == "SUCCESS"
        for name in written:
            kept = good or name in self.call.target.inouts
            self._keep(name, held[name] if kept else Slot(name))
        if not good:
            self._raise()
        return Outputs(self.call.target.name, {name: _value(held[name]) for name in written})

    def _keep(self, name: str, slot: Slot) -> None:
        """Keep a record for later calls, or forget the one before where there is none now."""
        types = self.call.target.outs | self.call.target.inouts
        if types[name].is_record:
            self.cell.records.pop(name, None)
            if slot.value is not MISSING:
                self.cell.records[name] = slot.value

    def _raise(self) -> None:
        status, reason, cause = self.outcome.status, self.outcome.reason, self.runner.cause
        if status == "INTERRUPTED":
            raise KeyboardInterrupt(reason)
        if cause is not None:
            raise cause
        if status == "FAULT":
            raise DeviceFault(self.call.target.name, "; ".join(self.outcome.errors) or reason)
        entry = f"{self.call.program.entry}/"
        path, _, why = reason.replace(f" {entry}", " ").removeprefix(entry).partition(": ")
        if status == "ERROR":
            raise NodeError(path, why or "; ".join(self.outcome.errors))
        raise Refused(f"{path}: {why}" if why else path, path)


def _value(slot: Slot) -> Any:
    if slot.value is MISSING:
        return None
    return slot.value if slot.sd is None else Estimate(slot.value, slot.sd)
