"""Small trees of probes that follow a script and note each call."""

import os
import signal
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

import stretch_bt
from stretch_bt.break_off import go_on
from stretch_bt.clock import VirtualClock
from stretch_bt.errors import DeviceFault, NoAnswer, TreeError
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.open_cell import OpenCell
from stretch_bt.runtime.runner import Runner
from stretch_bt.tree import registry
from stretch_bt.tree.build import build
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.ports import Behavior, In, Status
from stretch_bt.tree.program import load_program

ENDS = {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING, "N": None, "I": Status.INVALID}


def interrupted_by(number: int) -> Callable[[], None]:
    return lambda: os.kill(os.getpid(), number)


def broken_off() -> None:
    """Be a solve during which a signal comes."""
    go_on()
    os.kill(os.getpid(), signal.SIGINT)
    go_on()
    raise AssertionError("the solve went on")


def raising(error: BaseException) -> Callable[[], None]:
    def act() -> None:
        raise error

    return act


ACTS: dict[str, Callable[[], None]] = {
    "X": raising(RuntimeError("broken")),
    "C": raising(NoAnswer("the numbers carry no answer")),
    "D": raising(DeviceFault("arm", "the arm says no")),
    "K": raising(KeyboardInterrupt()),
    "Q": raising(SystemExit(3)),
    "i": interrupted_by(signal.SIGINT),
    "t": interrupted_by(signal.SIGTERM),
    "b": broken_off,
}


class Probe(Behavior):
    """Ends each tick with the next letter of its script, of which the last one stays; a lower-case letter acts, then runs."""

    instant: ClassVar[bool] = False
    trace: ClassVar[list[str]] = []
    script: In[str] = "S"
    stop_script: In[str] = ""  # what `terminate` does
    keep: In[bool] = False  # whether the script goes on where it was when the node starts again

    def initialise(self) -> None:
        self.trace.append(f"{self.name}.init")
        self.step = 0 if not self.keep else getattr(self, "step", 0)

    def update(self) -> Status:
        self.trace.append(f"{self.name}.tick")
        letter = self.script[min(self.step, len(self.script) - 1)]
        self.step += 1
        ACTS.get(letter, lambda: None)()
        return ENDS.get(letter, Status.RUNNING)  # type: ignore[return-value]

    def terminate(self, new_status: Status) -> None:
        self.trace.append(f"{self.name}.term({new_status.name[0]})")
        for letter in self.stop_script:
            ACTS[letter]()


class Ask(Probe):
    """A probe that always ends at once, as a condition does."""

    instant: ClassVar[bool] = True


class Events:
    """A watcher that keeps everything."""

    def __init__(self) -> None:
        self.statuses: list[tuple[int, str, str, str]] = []
        self.notes: list[tuple[str, dict[str, Any]]] = []
        self.writes: list[tuple[str, Any]] = []
        self.ticks: list[tuple[int, float]] = []

    def begin_tick(self, tick: int, time: float) -> None:
        self.ticks.append((tick, time))

    def status(self, path: str, status: str, reason: str = "") -> None:
        self.statuses.append((self.ticks[-1][0] if self.ticks else 0, path, status, reason))

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        self.writes.append((key, value))

    def note(self, kind: str, **fields: Any) -> None:
        self.notes.append((kind, fields))

    def of(self, kind: str) -> list[dict[str, Any]]:
        return [fields for name, fields in self.notes if name == kind]


class Devices:
    """A cell that counts how often it was stopped, and gives scripted answers."""

    def __init__(self, *answers: Any) -> None:
        self.answers = list(answers)
        self.stops = 0

    def stop(self) -> list[Exception]:
        self.stops += 1
        answer = self.answers.pop(0) if self.answers else []
        if isinstance(answer, BaseException):
            raise answer
        return list(answer)


class Bench:
    """Builds and runs the body of a `main`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.trace = Probe.trace
        self.events = Events()
        self.count = 0
        self.Devices = Devices

    def text(self, body: str, head: str = "", trees: str = "") -> str:
        main = textwrap.indent(textwrap.dedent(body).strip(), "    ")
        other = textwrap.indent(textwrap.dedent(trees).strip(), "  ")
        return f"format: stretch-tree/1\n{textwrap.dedent(head).strip()}\ntrees:\n  main:\n{main}\n{other}\n"

    def program(self, body: str, head: str = "", trees: str = "") -> Any:
        self.count += 1
        path = self.folder / f"tree{self.count}.yaml"
        path.write_text(self.text(body, head, trees), encoding="utf-8")
        return load_program(path)

    def codes(self, body: str, head: str = "", trees: str = "") -> set[str]:
        """Return the codes of the errors in a tree that does not load."""
        try:
            found = self.program(body, head, trees).diagnostics
        except TreeError as error:
            found = error.diagnostics
        return {d.code for d in found if d.severity == "error"}

    def build(self, body: str, head: str = "", trees: str = "", context: RunContext | None = None) -> BuiltTree:
        return build(self.program(body, head, trees).require(), context or RunContext())

    def runner(self, body: str | BuiltTree, head: str = "", trees: str = "", **options: Any) -> Runner:
        context = options.pop("context", None) or RunContext()
        tree = self.build(body, head, trees, context) if isinstance(body, str) else body
        clock = options.pop("clock", None) or VirtualClock()
        options.setdefault("watchers", [self.events])
        return Runner(tree, context, clock, **{"period": 0.05, "max_ticks": 50, **options})

    def run(self, body: str | BuiltTree, head: str = "", trees: str = "", **options: Any) -> Any:
        return self.runner(body, head, trees, **options).run()


@pytest.fixture
def bench(tmp_path: Path, own_nodes: None) -> Iterator[Bench]:
    """Trees of `probe` and `ask`, and what was done to them in `bench.trace`."""
    registry.node(Probe)
    registry.node(Ask)
    Probe.trace.clear()
    yield Bench(tmp_path)
    Probe.trace.clear()


@pytest.fixture
def opened() -> Iterator[OpenCell]:
    """An open cell, simulated over a sphere."""
    with stretch_bt.open_cell(scene="calibration_sphere") as cell:
        yield cell
