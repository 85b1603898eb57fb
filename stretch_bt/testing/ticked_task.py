"""A task that a test ticks by hand, with the runner that every run has."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from py_trees.common import Status

from stretch_bt.clock import Clock, VirtualClock
from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import Device
from stretch_bt.runtime.borrowed_devices import BorrowedDevices, borrow
from stretch_bt.runtime.context import Commanded, Seen
from stretch_bt.runtime.foreign_nodes import kept_for, paced_for
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.outcome import Outcome
from stretch_bt.runtime.result import keys_of_main, unmet_of
from stretch_bt.runtime.runner import Runner
from stretch_bt.runtime.task import task_of
from stretch_bt.source import did_you_mean
from stretch_bt.threads import one_thread
from stretch_bt.units import KINDS

if TYPE_CHECKING:
    from stretch_bt.hardware.cell import Cell

__all__ = ["TickedTask"]

_ENDED = {"SUCCESS": Status.SUCCESS, "FAILURE": Status.FAILURE}
#: number of latest events that a message of `until` lists
_SHOWN = 12
_ROUNDING = 1e-9  # s


class TickedTask:
    """A task under test: it goes on by one tick at each call, on a virtual clock.

    It opens the simulated cell with the tree's own scene where it needs devices and is given none. When the task ends, its `finally`
    is run and the devices are stopped, in the tick that ended it; `close` does both where the test ends before the task.
    """

    def __init__(
        self,
        tree: str | Path,
        *,
        mocks: str | Path | Mapping[str, Any] | None = None,
        devices: Mapping[str, Device] | None = None,
        modules: Path | None = None,
        folder: Path | None = None,
    ) -> None:
        given = None if devices is None else borrow(devices)
        task = task_of(tree, None, None, {}, 0, mocks, modules, given)
        self._clock: Clock = VirtualClock()
        self._seen = Seen(now=lambda: self.now)
        self._changes = _Changes()
        self._open = ExitStack()
        self._task = task
        self._nodes = task.built.nodes
        self._after: dict[str, Status] | None = None
        task.context.folder = folder
        with ExitStack() as opening:  # a tree that cannot be begun leaves nothing open
            opening.enter_context(kept_for(task.built))
            cell = self._taken(given, opening) if given is not None else self._opened()
            if cell is not None:
                task.context.devices = cell.devices
                opening.callback(cell.close)
            opening.enter_context(one_thread())
            self._runner = Runner(
                task.built,
                task.context,
                paced_for(task.built, self._clock),
                period=task.program.document.tick_period,
                cell=cell,
                watchers=[self._changes],
                max_ticks=task.most_ticks(),
            )
            self._runner.begin()
            self._open = opening.pop_all()

    def tick(self) -> Status:
        """Tick once, and return the status of the task; INVALID where it ended with an error, a fault or an interrupt.

        After the end it returns that status again, without a tick.
        """
        if self._after is None:
            self._changes.latest.clear()
            with self._runner.attended():
                if not self._runner.step():
                    self._end()
        return Status.RUNNING if self._after is None else _ENDED.get(self.outcome.status, Status.INVALID)

    def until(self, path: str, status: Status | str = "RUNNING", within: float | str = "60 s") -> TickedTask:
        """Tick until the node at the path has the status, or comes to it and leaves it within one tick; at once where it has it now.

        Raises
        ------
        AssertionError
            It had not within this virtual time, text with a unit or s, or the task ended before; the message says what was seen.
        InvalidInput
            No node has this path, or there is no such status.
        """
        wanted = _status(status)
        limit = within if isinstance(within, int | float) else KINDS["Time"].parse(within)
        began = self.now
        found = self.status(path) is wanted
        while not found:
            if self._after is not None:
                raise AssertionError(self._unmet(path, wanted, f"the task ended with {self.outcome.status}"))
            if self._runner.deadline > began + limit + _ROUNDING:
                raise AssertionError(self._unmet(path, wanted, f"{limit:g} s are over"))
            self.tick()
            found = self.status(path) is wanted or (path, wanted.name) in self._changes.latest
        return self

    def status(self, path: str) -> Status:
        """Return the status that the node at a path has now, after the end the one that it ended with; INVALID where it did not start."""
        if path not in self._nodes:
            hint = did_you_mean(path, self._nodes) or "`stretch-bt show TREE` lists the paths"
            raise InvalidInput(f"the tree has no node at {path!r}; {hint}")
        return self._nodes[path].status if self._after is None else self._after[path]

    @property
    def keys(self) -> dict[str, Any]:
        """What the keys of `main` hold now, in SI; a number with a deviation is an Estimate."""
        return keys_of_main(self._task.built)

    def commands(self, device: str) -> list[Commanded]:
        """Return what nodes commanded a device so far, by the name that the tree declares."""
        declared = self._task.program.document.devices
        if device not in declared:
            raise InvalidInput(
                f"the tree declares no device {device!r}; {did_you_mean(device, declared) or 'it declares none'}"
            )
        return [command for command in self._seen.commands if command.device == device]

    @property
    def now(self) -> float:
        """Virtual time, s; the first tick is at 0."""
        return self._clock.now()

    @property
    def ticks(self) -> int:
        """Number of ticks so far, the ticks of `finally` included."""
        return self._task.context.ticks

    @property
    def outcome(self) -> Outcome:
        """How the task ended: `status`, which may also be ERROR, FAULT or INTERRUPTED, and `reason`."""
        return self._runner.outcome

    @property
    def reason(self) -> str:
        """Why the task ended as it did; nothing as long as it goes on, or where it succeeded."""
        return self.outcome.reason if self._after is not None else ""

    @property
    def unmet(self) -> list[str]:
        """What the mocks expected that has not come true, as of a run that ended now."""
        visited = {(path, status) for _, path, status in self._changes.all}
        return unmet_of(self._task, self.outcome, visited, self._seen)

    def close(self) -> Outcome:
        """End the task where it goes on, safely: interrupt its nodes, run its `finally`, stop and close its devices."""
        with self._open:
            if self._after is None:
                with self._runner.attended():
                    self._runner.interrupt("the end of the test")
                    self._runner.step()
                    self._end()
        return self.outcome

    def _taken(self, given: BorrowedDevices, opening: ExitStack) -> BorrowedDevices:
        missing = sorted(self._task.devices() - given.devices.keys())
        if missing:
            raise InvalidInput(
                f"the tree needs {', '.join(missing)}; give it in 'devices', or mock the nodes that use it"
            )
        self._clock = given.clock
        self._task.prepare(given.hand, given.limits)
        opening.enter_context(given.heard_by(self._seen))
        return given

    def _opened(self) -> Cell | None:
        spec = self._task.cell_spec()
        if spec is None:
            self._task.prepare()
            return None
        self._task.prepare(Hand(spec.hand), spec.limits)
        from stretch_bt.hardware.cell import open_cell
        from stretch_bt.simulation.scene import load_scene

        if self._task.scene is None:
            needed = ", ".join(sorted(self._task.devices()))
            raise InvalidInput(f"the tree needs {needed}; give it in 'devices', mock its nodes, or name a scene in it")
        scene, wanted = load_scene(self._task.scene), self._task.devices()
        cell = open_cell(spec, clock=self._clock, scene=scene, journal=self._seen, only=wanted)
        self._task.context.hand = cell.hand
        return cell

    def _end(self) -> None:
        """Finish, and keep the statuses that nodes had after the last tick, which a safe end clears."""
        self._after = {path: node.status for path, node in self._nodes.items()}
        ticked, self._changes.latest = self._changes.latest, {}
        self._runner.finish()
        self._after |= {path: Status[name] for path, name in self._changes.latest}
        self._changes.latest = ticked | self._changes.latest  # the end belongs to the tick that brought it

    def _unmet(self, path: str, wanted: Status, why: str) -> str:
        lines = [f"{path} did not come to {wanted.name}: {why} at {self.now:g} s, tick {self.ticks}"]
        lines += [f"it is {self.status(path).name}"] + ([self.reason] if self.reason else [])
        seen = [f"  {time:8.3f} s  {name:8} {at}" for time, at, name in self._changes.all[-_SHOWN:]]
        return "\n".join(["; ".join(lines), "the latest changes of status:" if seen else "no node was ticked", *seen])


class _Changes(Onlooker):
    """A watcher that keeps which node came to which status when, and the statuses of the latest tick by themselves."""

    def __init__(self) -> None:
        self.all: list[tuple[float, str, str]] = []
        self.latest: dict[tuple[str, str], None] = {}
        self._time = 0.0

    def begin_tick(self, tick: int, time: float) -> None:
        """Know the time."""
        self._time = time

    def status(self, path: str, status: str, reason: str = "") -> None:
        """Keep it."""
        self.all.append((self._time, path, status))
        self.latest.pop((path, status), None)  # the last one comes last
        self.latest[path, status] = None


def _status(given: Status | str) -> Status:
    name = given.name if isinstance(given, Status) else str(given).upper()
    if name not in Status.__members__:
        raise InvalidInput(f"{given!r} is no status of a node; {did_you_mean(name, Status.__members__)}")
    return Status[name]
