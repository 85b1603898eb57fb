"""Calls on an open cell: a node or a library subtree, ticked to its end by the runner of tasks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from stretch_bt.clock import VirtualClock
from stretch_bt.errors import DeviceFault, InvalidInput, NodeError, Refused, StretchError
from stretch_bt.hardware.cell import Cell
from stretch_bt.runtime.foreign_nodes import kept_for, paced_for
from stretch_bt.runtime.one_call import OneCall, called, names
from stretch_bt.runtime.outcome import Outcome
from stretch_bt.runtime.outputs import Outputs
from stretch_bt.runtime.prepare_nodes import prepare_nodes
from stretch_bt.runtime.runner import LONGEST, Runner
from stretch_bt.threads import one_thread
from stretch_bt.tree.build import build
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.cell import Cell as Slot

if TYPE_CHECKING:
    from stretch_bt.runtime.open_cell import OpenCell

__all__ = ["Do"]


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

        def call(**ports: Any) -> Outputs:
            return self(name, **ports)

        call.__name__, call.__qualname__, call.__doc__ = name, f"do.{name}", target.help()
        call.__signature__ = target.signature()  # type: ignore[attr-defined]
        return call

    def __repr__(self) -> str:
        return f"<do of {self._open!r}>"


class _StopUnlessDone:
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
        cell.settle()
        context = cell.new_context()
        self.built: BuiltTree = build(call.program, context)
        self._check_devices()
        for slot in self._slots():
            name = slot.name.rpartition("/")[2]
            if name in call.values:
                slot.write(call.values[name])
        prepare_nodes(self.built)
        quiet = _StopUnlessDone(cell.cell)
        virtual = isinstance(cell.clock, VirtualClock) and not self.built.foreign
        self.runner = Runner(
            self.built,
            context,
            paced_for(self.built, cell.clock),
            period=cell.grid.period,
            cell=quiet,
            watchers=[] if cell._record is None else [cell._record],
            longest=LONGEST if virtual else float("inf"),
            grid=cell.grid,
        )
        quiet.outcome = self.runner.outcome
        cell.between.listen()
        with cell.between.calling(self.runner), kept_for(self.built):
            self.outcome = self.runner.run()

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
        return Outputs(self.call.target.name, {name: held[name].held() for name in written})

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
