"""What a tick costs: our tree of 100 leaves with one input and one output port each, beside bare py_trees.

Run with `python benchmarks/tick_cost.py [leaves] [rounds]`. The same shape in every row: a sequence without memory, so that
every leaf is ticked on every tick. CPU time, median over rounds in which the rows take turns; p99 is of single ticks, wall
time. The target is at most 1.3 times bare py_trees without ports, and p99 under 2 ms. The last line is the cost in a tick
of checking the outputs of nodes, at most 5 % of a tick with its record, which every run has.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Generator
from contextlib import ExitStack
from threading import get_ident

import py_trees
from py_trees.common import Status

from stretch_bt.accuracy.runner.leaf import BenchmarkLeaf
from stretch_bt.accuracy.runner.ticks import TREES, Tick, ours
from stretch_bt.errors import NoAnswer, NodeError
from stretch_bt.forked import here, leave_if_forked
from stretch_bt.tree.ports import Behavior
from stretch_bt.tree.registry import node

TICKS = 20
SUCCESS, FAILURE, RUNNING = Status.SUCCESS, Status.FAILURE, Status.RUNNING


class Unchecked:
    """An output port that hands on whatever is written."""

    def __set__(self, leaf: Behavior, value: float) -> None:
        leaf.sinks["result"].write(value, leaf.path)


@node
class UncheckedLeaf(BenchmarkLeaf):
    """Write what was read, and look neither at the value nor at whether there was one."""


def unchecked_tick(self: Behavior) -> Generator[py_trees.behaviour.Behaviour, None, None]:
    """Tick as a node does, without a look at what was written."""
    self.ticked_by = get_ident()
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
    if here.forked:
        leave_if_forked()
    if status is not RUNNING:
        if status is not SUCCESS and status is not FAILURE:
            raise NodeError(self.path, "no status")
        self.stop(status)
    self.status = status
    self.ticking = False
    yield self


# a node may not override it
UncheckedLeaf.tick = unchecked_tick  # type: ignore[method-assign]
UncheckedLeaf.result = Unchecked()  # type: ignore[assignment]


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


def main(leaves: int, rounds: int, close: ExitStack) -> None:
    rows = {name: make(leaves, close) for name, make in TREES.items()}
    rows["the same, ports unchecked"] = ours(leaves, close, leaf="unchecked_leaf")
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
    alone, whole = more / statistics.median(unchecked), more / statistics.median(times["stretch-bt, with its record"])
    print(f"checking what {leaves} nodes write takes {more * 1e6:.0f} us: {100 * alone:.1f} % of a tick without a record, "
          f"{100 * whole:.2f} % of one with a record")  # fmt: skip


if __name__ == "__main__":
    with ExitStack() as held:
        count, turns = (int(a) for a in [*sys.argv[1:], *("100", "100")[len(sys.argv) - 1 :]])
        main(count, turns, held)
