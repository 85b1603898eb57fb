"""What a tick costs: our tree of 100 leaves with one input and one output port each, beside bare py_trees.

Run with `python benchmarks/tick_cost.py [leaves] [rounds]`. The same shape in every row: a sequence without memory, so that
every leaf is ticked on every tick. CPU time, median over rounds in which the rows take turns; p99 is of single ticks, wall
time. The target is at most 1.3 times bare py_trees without ports, and p99 under 2 ms. The last line is what it adds to a tick
to check what nodes write, at most 5 % of a tick with its record, which every run has.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path
from tempfile import TemporaryDirectory

import py_trees
from py_trees.common import Status
from py_trees.ports import BehaviourWithPorts, PortInformation

from stretch_bt.clock import VirtualClock
from stretch_bt.errors import NoAnswer, NodeError
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.record import RunRecord
from stretch_bt.runtime.runner import Runner, Watcher
from stretch_bt.tree.build import build
from stretch_bt.tree.ports import Behavior, In, Out
from stretch_bt.tree.program import load_program
from stretch_bt.tree.registry import node

TICKS = 20
SUCCESS, FAILURE, RUNNING = Status.SUCCESS, Status.FAILURE, Status.RUNNING
Tick = Callable[[], object]


class Bare(py_trees.behaviour.Behaviour):
    """A leaf without ports."""

    def update(self) -> Status:
        """Succeed."""
        return Status.SUCCESS


class Ported(BehaviourWithPorts):
    """A leaf with py_trees' own ports."""

    INPUT_PORTS = {"given": PortInformation(data_type=float, required=True)}  # noqa: RUF012
    OUTPUT_PORTS = {"result": PortInformation(data_type=float, required=True)}  # noqa: RUF012

    def update(self) -> Status:
        """Pass it on."""
        self._set_output("result", self.get_input("given"))
        return Status.SUCCESS


@node
class BenchmarkLeaf(Behavior):
    """Write what was read."""

    instant = True
    given: In[float]
    result: Out[float]

    def update(self) -> Status:
        """Pass it on."""
        self.result = self.given
        return Status.SUCCESS


class Unchecked:
    """An output port that hands on whatever is written."""

    def __set__(self, leaf: Behavior, value: float) -> None:
        leaf.sinks["result"].write(value, leaf.path)


@node
class UncheckedLeaf(BenchmarkLeaf):
    """Write what was read, and look neither at the value nor at whether there was one."""

    def tick(self) -> Generator[py_trees.behaviour.Behaviour, None, None]:
        """Tick as a node does, without a look at what was written."""
        self.ticking = True
        try:
            if self.status is not RUNNING:
                self.feedback_message = ""
                self.runs += 1
                self.active = True
                self.initialise()
            status = self.update()
        except NoAnswer:
            status = FAILURE
        if status is not RUNNING:
            if status is not SUCCESS and status is not FAILURE:
                raise NodeError(self.path, "no status")
            self.stop(status)
        self.status = status
        self.ticking = False
        yield self


UncheckedLeaf.result = Unchecked()  # type: ignore[assignment]


def bare(leaves: int) -> Tick:
    root = py_trees.composites.Sequence("root", memory=False, children=[Bare(f"leaf{i}") for i in range(leaves)])
    return py_trees.trees.BehaviourTree(root).tick


def ported(leaves: int) -> Tick:
    children = [Ported(f"leaf{i}") for i in range(leaves)]
    for i, child in enumerate(children):
        child.setup_ports({"given": "/k0" if i == 0 else f"/k{i}", "result": f"/k{i + 1}"})
    root = py_trees.composites.Sequence("root", memory=False, children=children)
    first = py_trees.blackboard.Client(name="first")
    first.register_key("/k0", access=py_trees.common.Access.WRITE)
    first.set("/k0", 1.0)
    return py_trees.trees.BehaviourTree(root).tick


def ours(leaves: int, folder: Path, record: RunRecord | None = None, leaf: str = "benchmark_leaf") -> Tick:
    keys = ", ".join(f"k{i}: {{type: float, default: 0}}" for i in range(leaves + 1))
    rows = "".join(f"      - {leaf}: {{given: $k{i}, result: $k{i + 1}}}\n" for i in range(leaves))
    path = folder / "tree.yaml"
    path.write_text(
        f"format: stretch-tree/1\nkeys: {{{keys}}}\ntrees:\n  main:\n    reactive_sequence:\n{rows}", "utf-8"
    )
    context = RunContext()
    tree = build(load_program(path).require(), context)
    watchers: list[Watcher] = [record] if record is not None else []
    runner = Runner(tree, context, VirtualClock(), period=0.02, watchers=watchers)
    return lambda: runner._tick(tree.root)


def cpu(tick: Tick) -> float:
    start = time.process_time()
    for _ in range(TICKS):
        tick()
    return (time.process_time() - start) / TICKS


def walls(tick: Tick, count: int) -> list[float]:
    found = []
    for _ in range(count):
        start = time.perf_counter()
        tick()
        found.append(time.perf_counter() - start)
    return sorted(found)


def main(leaves: int, rounds: int, folder: Path) -> None:
    record = RunRecord(folder / "record")
    record.start({}, {})
    rows = {
        "py_trees, no ports": bare(leaves),
        "py_trees, its own ports": ported(leaves),
        "stretch-bt, no record": ours(leaves, folder),
        "stretch-bt, with a record": ours(leaves, folder, record),
        "the same, ports unchecked": ours(leaves, folder, leaf="unchecked_leaf"),
    }
    for tick in rows.values():
        cpu(tick)
    times: dict[str, list[float]] = {name: [] for name in rows}
    for _ in range(rounds):
        for name, tick in rows.items():
            times[name].append(cpu(tick))
    reference = times["py_trees, no ports"]
    print(f"{leaves} leaves, median of {rounds} rounds of {TICKS} ticks, CPU time")
    for name, tick in rows.items():
        ratio = statistics.median(a / b for a, b in zip(times[name], reference, strict=True))
        wall = walls(tick, 1000)
        print(f"{name:28s}{statistics.median(times[name]) * 1e6:8.0f} us a tick {ratio:6.2f} times bare py_trees   "
              f"p50 {wall[500] * 1e3:.2f} ms   p99 {wall[990] * 1e3:.2f} ms")  # fmt: skip
    checked, unchecked = times["stretch-bt, no record"], times["the same, ports unchecked"]
    more = statistics.median(a - b for a, b in zip(checked, unchecked, strict=True))
    alone, whole = more / statistics.median(unchecked), more / statistics.median(times["stretch-bt, with a record"])
    print(f"checking what {leaves} nodes write takes {more * 1e6:.0f} us: {100 * alone:.1f} % of a tick without a record, "
          f"{100 * whole:.2f} % of one with a record")  # fmt: skip
    record.close({})


if __name__ == "__main__":
    with TemporaryDirectory() as place:
        count, turns = (int(a) for a in [*sys.argv[1:], *("100", "100")[len(sys.argv) - 1 :]])
        main(count, turns, Path(place))
