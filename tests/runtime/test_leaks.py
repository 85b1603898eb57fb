import gc
import shutil
import signal
import threading
import tracemalloc
from pathlib import Path
from typing import Any

import py_trees

from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.task import run
from stretch_bt.tree import registry
from stretch_bt.tree.build import build
from stretch_bt.tree.ports import Behavior
from stretch_bt.tree.program import load_program

TREE = """\
format: stretch-tree/1
keys: {n: {type: int, default: 0}, x: Length}
trees:
  main:
    out: {total: int}
    guard: {that: n < 100, name: few}
    sequence:
      - set: {x: 1 mm}
      - until:
          that: n >= 3
          max: 10
          do: {sequence: [wait: {duration: 50 ms}, count: {from: $n, to: $n}]}
      - parallel: [{name: a, wait: {duration: 100 ms}}, {name: b, wait: {duration: 100 ms}}]
      - set: {total: n}
    finally: [wait: {duration: 50 ms}]
  count: {in: {from: int}, out: {to: int}, set: {to: from + 1}}
"""


def held() -> dict[str, Any]:
    """Return what a forgotten run might leave behind, counted."""
    gc.collect()
    board = py_trees.blackboard.Blackboard
    return {
        "clients": len(board.clients),
        "storage": len(board.storage),
        "metadata": len(board.metadata),
        "handlers": [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)],
        "threads": threading.active_count(),
        "files": len(list(Path("/proc/self/fd").iterdir())) if Path("/proc/self/fd").exists() else 0,
        "nodes": len(registry.load_all()),
        "behaviours": sum(isinstance(o, py_trees.behaviour.Behaviour) for o in gc.get_objects()),
        "classes": len(Behavior.__subclasses__()),
    }


def test_a_hundred_runs_leave_nothing(bench: Any, tmp_path: Path) -> None:
    """Load, run, discard: the first to warm up, then nothing may grow, and memory by less than 100 bytes a cycle."""
    path = tmp_path / "tree.yaml"
    path.write_text(TREE, encoding="utf-8")

    def cycle(times: int) -> None:
        for _ in range(times):
            context = RunContext()
            tree = build(load_program(path).require(), context)
            assert bench.run(tree, context=context, watchers=[type(bench.events)()]).status == "SUCCESS"

    cycle(20)
    before = held()
    tracemalloc.start()
    try:
        cycle(20)
        gc.collect()
        start = tracemalloc.get_traced_memory()[0]
        cycle(100)
        after = held()
        grown = tracemalloc.get_traced_memory()[0] - start
    finally:
        tracemalloc.stop()
    assert after == before
    assert grown < 100 * 100, f"{grown / 100:.0f} bytes a cycle"


def test_runs_with_a_record_leave_nothing(tmp_path: Path) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(TREE, encoding="utf-8")

    def cycle() -> None:
        assert run(path, out=tmp_path / "record").status == "SUCCESS"
        shutil.rmtree(tmp_path / "record")

    for _ in range(5):
        cycle()
    before = held()
    for _ in range(20):
        cycle()
    assert held() == before
