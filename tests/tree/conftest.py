"""Small tasks on a virtual clock, made of steps that follow a script."""

import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

from stretch_bt.clock import VirtualClock
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.runner import Runner
from stretch_bt.tree import registry
from stretch_bt.tree.build import build
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.program import Program, load_program
from stretch_bt.units import Estimate, Length

LETTERS = {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING}
PERIOD = 0.05


class Step(Behavior):
    """Ends each tick with the next letter of its script, also when it starts again; the last one stays."""

    trace: ClassVar[list[str]] = []
    script: In[str] = "S"

    def initialise(self) -> None:
        self.trace.append(f"{self.name}+")

    def update(self) -> Status:
        at = getattr(self, "at", 0)
        self.at = at + 1
        letter = self.script[min(at, len(self.script) - 1)]
        self.trace.append(f"{self.name}{letter}")
        return LETTERS[letter]

    def terminate(self, new_status: Status) -> None:
        if new_status is Status.INVALID:
            self.trace.append(f"{self.name}!")


class Ask(Step):
    """A step that ends at once."""

    instant: ClassVar[bool] = True


class Show(Behavior):
    """Notes the length that it is given."""

    instant: ClassVar[bool] = True
    value: In[Length]

    def update(self) -> Status:
        Step.trace.append(f"{self.value * 1000:g}")
        return Status.SUCCESS


class Measure(Behavior):
    """Gives a length with its standard deviation."""

    instant: ClassVar[bool] = True
    value: In[Length] = 0.007
    length: Out[Length]

    def update(self) -> Status:
        self.length = Estimate(self.value, 0.001)
        return Status.SUCCESS


class Many(Behavior):
    """Gives lists."""

    instant: ClassVar[bool] = True
    some: Out[list[Length]]
    none: Out[list[Length]]

    def update(self) -> Status:
        self.some, self.none = [0.001, 0.0, 0.003], []
        return Status.SUCCESS


class Events:
    """A watcher that keeps every change."""

    def __init__(self) -> None:
        self.tick = 0
        self.statuses: list[tuple[int, str, str, str]] = []
        self.writes: list[tuple[str, Any]] = []

    def begin_tick(self, tick: int, time: float) -> None:
        self.tick = tick

    def status(self, path: str, status: str, reason: str = "") -> None:
        self.statuses.append((self.tick, path, status, reason))

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        self.writes.append((key, value))

    def note(self, kind: str, **fields: Any) -> None: ...


class Task:
    """Writes, checks, builds and runs a task, given the body of `main` and what stands around it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.trace = Step.trace
        self.events = Events()

    def text(self, body: str, head: str = "", trees: str = "") -> str:
        main = textwrap.indent(textwrap.dedent(body).strip(), "    ")
        other = textwrap.indent(textwrap.dedent(trees).strip(), "  ")
        return f"format: stretch-tree/1\n{textwrap.dedent(head).strip()}\ntrees:\n  main:\n{main}\n{other}\n"

    def load(self, body: str, head: str = "", trees: str = "") -> Program:
        path = self.folder / "task.yaml"
        path.write_text(self.text(body, head, trees))
        return load_program(path).require()

    def build(self, body: str, head: str = "", trees: str = "", context: RunContext | None = None) -> BuiltTree:
        return build(self.load(body, head, trees), context or RunContext())

    def run(self, body: str, head: str = "", trees: str = "", **options: Any) -> Any:
        """Run it and return the outcome; `outputs` of the tree, and what the steps did, are kept."""
        self.trace.clear()
        self.events = Events()
        context = options.pop("context", None) or RunContext()
        self.built = self.build(body, head, trees, context)
        runner = Runner(self.built, context, VirtualClock(), period=PERIOD, watchers=[self.events], max_ticks=200)
        return runner.run()

    @property
    def did(self) -> str:
        """What the steps did, in a line."""
        return " ".join(self.trace)

    def output(self, name: str) -> tuple[Any, float | None]:
        """Return value and standard deviation of an output of `main`."""
        cell = self.built.outputs[name][1]
        return cell.value, cell.sd


@pytest.fixture
def task(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Task]:
    registry.load_all()
    monkeypatch.setattr(registry, "_nodes", dict(registry._nodes))
    for cls in (Step, Ask, Show, Measure, Many):
        registry.node(cls)
    yield Task(tmp_path)
    Step.trace.clear()
