"""Ticks of a sequence of leaves, built by py_trees alone and by us."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from itertools import product
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import py_trees

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.points import Answer, Cost, Setting
from stretch_bt.accuracy.runner.leaf import Bare, BenchmarkLeaf, Ported
from stretch_bt.clock import VirtualClock
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.foreign_nodes import kept_blackboard
from stretch_bt.runtime.record import RunRecord
from stretch_bt.runtime.runner import Runner
from stretch_bt.runtime.watcher import Watcher
from stretch_bt.tree.build import build
from stretch_bt.tree.program import load_program
from stretch_bt.tree.registry import node

__all__ = ["TREES", "Tick", "bare", "jobs", "ours", "ported", "recorded", "warm"]

Tick = Callable[[], object]

LEAVES, ROUNDS = (100, 10, 30, 300), 20
_TICKS, _FIRST = 30, 5  # that are timed in a round, and those before them


def bare(leaves: int, close: ExitStack) -> Tick:
    """Return the tick of leaves without ports."""
    return _bare_tree([Bare(f"leaf{i}") for i in range(leaves)])


def ported(leaves: int, close: ExitStack) -> Tick:
    """Return the tick of leaves with py_trees' own ports, one writing what the next one reads."""
    children = [Ported(f"leaf{i}") for i in range(leaves)]
    for i, child in enumerate(children):
        child.setup_ports({"given": "/k0" if i == 0 else f"/k{i}", "result": f"/k{i + 1}"})
    first = py_trees.blackboard.Client(name="first")
    first.register_key("/k0", access=py_trees.common.Access.WRITE)
    first.set("/k0", 1.0)
    return _bare_tree(children)


def _bare_tree(children: list[Any]) -> Tick:
    root = py_trees.composites.Sequence("root", memory=False, children=children)
    tick: Tick = py_trees.trees.BehaviourTree(root).tick
    return tick


def ours(leaves: int, close: ExitStack, leaf: str = "benchmark_leaf", record: RunRecord | None = None) -> Tick:
    """Return the tick of our leaves with a port in and a port out, wired in a row."""
    node(BenchmarkLeaf)
    keys = ", ".join(f"k{i}: {{type: float, default: 0}}" for i in range(leaves + 1))
    rows = "".join(f"      - {leaf}: {{given: $k{i}, result: $k{i + 1}}}\n" for i in range(leaves))
    path = Path(close.enter_context(TemporaryDirectory())) / "tree.yaml"
    text = f"format: stretch-tree/1\nkeys: {{{keys}}}\ntrees:\n  main:\n    reactive_sequence:\n{rows}"
    path.write_text(text, encoding="utf-8")
    context = RunContext()
    tree = build(load_program(path).require(), context)
    watchers: list[Watcher] = [record] if record is not None else []
    runner = Runner(tree, context, VirtualClock(), period=0.02, watchers=watchers)
    runner.begin()
    return lambda: runner.ticker.tick(tree.root)


def recorded(leaves: int, close: ExitStack) -> Tick:
    """Return the same with a record of every write."""
    record = RunRecord(Path(close.enter_context(TemporaryDirectory())) / "record")
    record.start({}, {})
    close.callback(record.close, {})
    return ours(leaves, close, record=record)


TREES: dict[str, Callable[[int, ExitStack], Tick]] = {
    "py_trees, no ports": bare,
    "py_trees, its own ports": ported,
    "stretch-bt, no record": ours,
    "stretch-bt, with its record": recorded,
}
_DEFAULT = ("stretch-bt, with its record", 100)


def warm() -> None:
    """Tick each kind of tree."""
    for series in TREES:
        _round(series, 2)


def jobs() -> Iterator[Job]:
    """Yield each kind of tree with each count of nodes, round by round."""
    for number, leaves, series in product(range(ROUNDS), LEAVES, TREES):
        setting, default = Setting(series, f"{leaves} nodes"), (series, leaves) == _DEFAULT
        seconds = 0.05 + leaves * 1e-3
        yield Job(f"round {number}", setting, "latency", seconds, partial(_round, series, leaves), default=default)


def _round(series: str, leaves: int) -> list[Answer]:
    with kept_blackboard(), ExitStack() as close:
        tick = TREES[series](leaves, close)
        for _ in range(_FIRST):
            tick()
        walls, cpus = zip(*(_timed(tick) for _ in range(_TICKS)), strict=True)
    nodes, cpu = Cost("nodes", leaves), median(cpus)
    return [Answer("latency", median(walls), cpu, cost=nodes), Answer("slowest", max(walls), cpu, cost=nodes)]


def _timed(tick: Tick) -> tuple[float, float]:
    wall, cpu = time.perf_counter(), time.process_time()
    tick()
    return time.perf_counter() - wall, time.process_time() - cpu
