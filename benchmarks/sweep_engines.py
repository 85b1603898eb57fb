"""The same rows from every engine of a sweep, whatever is killed; the cost of an item, and the memory that a worker keeps.

    python benchmarks/sweep_engines.py [ITEMS] [--workers 2] [--engines local dask] [--kill none worker sweep both] [--seed 0]
        [--fidelity NAME] [--tree FILE] [--memory 60] [--keep DIR]

ITEMS palpations of the four balloons (12 by default) run one after the other in one process; then on worker processes by joblib
and by Dask, undisturbed, and each with SIGKILL to a worker, to the sweep, and to both at a random moment, gone on with by
--resume. `--kill` names which of these are run. Rows are compared sorted by their keys, but for times and workers. Then one item
of ITEMS ends its own process. `--memory` adds the resident memory of each Dask worker after its items 20 and 60. Ends with 1
where anything differs from the first run. `--fidelity` replaces the fidelity of the scenes. `--tree` replaces the palpation by a
tree that needs no scene, for a quick look at the engines themselves.
"""

from __future__ import annotations

import argparse
import json
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil

from stretch_bt.simulation.scene import scene_text

BALLOONS = ("air_balloon", "water_balloon", "pudding_balloon", "seeds_balloon")
DISTURBED = ("worker", "sweep", "both")
#: of the deadly sweep: the number of the item that ends its process
DEADLY = 3
MODULE = '''\
import os
import signal

from stretch_bt import Behavior, In, Out, Status, node


@node
class EndAt(Behavior):
    """End the process where a number is another's."""

    number: In[int]
    deadly: In[int]
    passed: Out[int]

    def update(self) -> Status:
        if self.number == self.deadly:
            os.kill(os.getpid(), signal.SIGKILL)
        self.passed = self.number
        return Status.SUCCESS
'''
TREE = f"""\
format: stretch-tree/1
imports: {{own: end_at}}
params: {{number: {{default: 1}}}}
trees:
  main:
    out: {{passed: int}}
    sequence:
      - end_at: {{number: $number, deadly: {DEADLY}, passed: $passed}}
"""


HELD = '''\
import psutil

from stretch_bt import Behavior, Out, Status, node


@node
class LookAtMemory(Behavior):
    """Read the resident memory of the process, MB."""

    held: Out[float]

    def update(self) -> Status:
        self.held = psutil.Process().memory_info().rss / 1e6
        return Status.SUCCESS
'''
WATCHED = """\
format: stretch-tree/1
imports: {own: held, palpation: palpate_stiffness.yaml}
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
trees:
  main:
    out: [stiffness, held]
    sequence:
      - look_at_memory: {held}
      - palpation.main: {stiffness}
"""


def rows_of(folder: Path) -> list[dict[str, Any]]:
    """Return the rows that count, sorted by their keys, but for times and workers."""
    lines = (folder / "rows.jsonl").read_text("utf-8").splitlines()
    last = {row["key"]: row for row in map(json.loads, lines)}
    return [
        {name: value for name, value in row.items() if not name.endswith("_seconds") and name != "worker"}
        for _, row in sorted(last.items())
    ]


def command(file: Path, out: Path, engine: str, workers: int, *more: str) -> list[str]:
    """Return the command of a sweep."""
    words = [sys.executable, "-m", "stretch_bt", "sweep", str(file), "--out", str(out), "--json", *more]
    return [*words, "--engine", engine, *([] if engine == "serial" else ["--workers", str(workers)])]


def swept(file: Path, out: Path, engine: str, workers: int, *more: str) -> tuple[int, dict[str, Any]]:
    """Run a sweep to its end; return its exit code and what it prints."""
    done = subprocess.run(command(file, out, engine, workers, *more), stdout=subprocess.PIPE, check=False)
    return done.returncode, json.loads(done.stdout or b"{}")


def workers_of(sweep: psutil.Process) -> list[psutil.Process]:
    """Return the processes in which items of a sweep run."""
    marks = ("popen_loky_posix", "spawn_main")
    return [child for child in sweep.children(recursive=True) if any(m in " ".join(_words(child)) for m in marks)]


def _words(process: psutil.Process) -> list[str]:
    try:
        return list(process.cmdline())
    except psutil.Error:
        return []


def count_rows(out: Path) -> int:
    path = out / "rows.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def disturbed(file: Path, out: Path, engine: str, workers: int, what: str, items: int, rng: random.Random) -> int:
    """Run a sweep, kill something of it at a random moment, and go on until each item has a row; return after how many rows."""
    begun = subprocess.Popen(command(file, out, engine, workers), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _wait_for(begun, out, rng.randrange(1, max(items - workers, 2)), rng)
    struck = count_rows(out)
    victims = workers_of(psutil.Process(begun.pid)) if begun.poll() is None else []
    if what in ("worker", "both") and victims:
        _kill(rng.choice(victims))
    if what in ("sweep", "both"):
        begun.kill()
    begun.wait()
    if what != "worker":
        _gone(victims)
        swept(file, out, engine, workers, "--resume")
    return struck


def _wait_for(begun: subprocess.Popen[bytes], out: Path, rows: int, rng: random.Random) -> None:
    """Wait until so many rows are there, and then for a part of the time in which another comes, whatever the machine."""
    first, seen = 0.0, 0
    while seen < rows and begun.poll() is None:
        time.sleep(0.02)
        now = count_rows(out)
        first, seen = (time.perf_counter(), now) if not seen else (first, now)
    pace = (time.perf_counter() - first) / (seen - 1) if seen > 1 else 0.1
    time.sleep(rng.uniform(0.0, pace))


def _kill(process: psutil.Process) -> None:
    with suppress(psutil.NoSuchProcess):
        process.kill()


def _gone(processes: list[psutil.Process]) -> None:
    """Wait until the workers of a sweep that was killed have ended; raises where one goes on for half a minute."""
    _, left = psutil.wait_procs(processes, timeout=30.0)
    assert not left, f"workers outlive their sweep: {left}"


def palpations(folder: Path, items: int, fidelity: str | None, tree: str = "palpate_stiffness") -> Path:
    """Write a sweep of palpations of the four balloons, at a fidelity where one is given."""
    path = folder / "palpations.yaml"
    names = BALLOONS if fidelity is None else [_at(folder, name, fidelity) for name in BALLOONS]
    scenes = f"scene: [{', '.join(names)}]\nseeds: {max(items // len(BALLOONS), 1)}\n"
    path.write_text(f"format: stretch-sweep/1\ntree: {tree}\n{scenes}", encoding="utf-8")
    return path


def _at(folder: Path, scene: str, fidelity: str) -> str:
    """Write a shipped scene at another fidelity; return its file's name."""
    lines = scene_text(scene).splitlines()
    text = "\n".join([line for line in lines if not line.startswith("fidelity:")] + [f"fidelity: {fidelity}\n"])
    (folder / f"{scene}.yaml").write_text(text, encoding="utf-8")
    return f"{scene}.yaml"


def of_tree(folder: Path, tree: Path, items: int) -> Path:
    """Write a sweep of another tree."""
    path = folder / "trees.yaml"
    (folder / tree.name).write_text(tree.read_text("utf-8"), encoding="utf-8")
    path.write_text(f"format: stretch-sweep/1\ntree: {tree.name}\nseeds: {items}\n", encoding="utf-8")
    return path


def deadly(folder: Path, items: int) -> Path:
    """Write a sweep of which one item ends its own process."""
    home = folder / "deadly"
    home.mkdir()
    (home / "end_at.py").write_text(MODULE, encoding="utf-8")
    (home / "tree.yaml").write_text(TREE, encoding="utf-8")
    numbers = ", ".join(map(str, range(items)))
    (home / "sweep.yaml").write_text(
        f"format: stretch-sweep/1\ntree: tree.yaml\nset: {{number: [{numbers}]}}\n", encoding="utf-8"
    )
    return home / "sweep.yaml"


def compared(given: argparse.Namespace, folder: Path) -> Iterator[tuple[str, bool, str]]:
    """Yield each run's name, whether its rows equal the first run's rows, and its cost."""
    file = (
        palpations(folder, given.items, given.fidelity)
        if given.tree is None
        else of_tree(folder, given.tree, given.items)
    )
    began = time.perf_counter()
    _, found = swept(file, folder / "serial", "serial", 1)
    wanted, rng = rows_of(folder / "serial"), random.Random(given.seed)
    yield "serial", len(wanted) == found["items"], _cost(found, time.perf_counter() - began)
    for engine in given.engines:
        if "none" in given.kill:
            began = time.perf_counter()
            _, found = swept(file, folder / engine, engine, given.workers)
            yield engine, rows_of(folder / engine) == wanted, _cost(found, time.perf_counter() - began)
        for what in [victim for victim in DISTURBED if victim in given.kill]:
            out, began = folder / f"{engine}-{what}", time.perf_counter()
            after = disturbed(file, out, engine, given.workers, what, len(wanted), rng)
            took = f"killed after {after} rows, {time.perf_counter() - began:.0f} s in all"
            yield f"{engine}, SIGKILL to {what}", rows_of(out) == wanted, took
    yield from ended_by_an_item(given, folder)


def ended_by_an_item(given: argparse.Namespace, folder: Path) -> Iterator[tuple[str, bool, str]]:
    """Yield whether the item that ends its process is the one row `killed` and all others came to SUCCESS."""
    file, items = deadly(folder, max(given.items, DEADLY + 1)), max(given.items, DEADLY + 1)
    for engine in given.engines:
        out = folder / f"deadly-{engine}"
        swept(file, out, engine, given.workers)
        ends = {row["set"]["number"]: row["status"] for row in rows_of(out)}
        wanted = {str(k): "killed" if k == DEADLY else "SUCCESS" for k in range(items)}
        yield f"{engine}, an item ends its worker", ends == wanted, f"{len(ends)} rows"


def _cost(found: dict[str, Any], wall: float) -> str:
    cpu = found["cpu_seconds"]
    return f"{cpu['median']:.2f} s CPU an item (p95 {cpu['p95']:.2f}), wall {wall:.0f} s, {found['statuses']}"


def memory(folder: Path, workers: int, last: int, fidelity: str | None) -> Iterator[tuple[str, bool, str]]:
    """Yield the resident memory of each worker after its items 20 and `last`, MB, and whether the two are within 5 %."""
    first = 20
    (folder / "held.py").write_text(HELD, encoding="utf-8")
    (folder / "watched.yaml").write_text(WATCHED, encoding="utf-8")
    file = palpations(folder, workers * (last + 8), fidelity, "watched.yaml")
    swept(file, folder / "memory", "dask", workers)
    held: dict[str, list[float]] = {}
    for line in (folder / "memory" / "rows.jsonl").read_text("utf-8").splitlines():
        row = json.loads(line)
        held.setdefault(row["worker"], []).append(row["outputs"]["held"]["value"])
    for name, sizes in held.items():
        if len(sizes) > last:
            before, after = sizes[first], sizes[last]  # each at the beginning of the next item
            good = abs(after / before - 1) < 0.05
            told = f"{before:.0f} MB after {first} items, {after:.0f} MB after {last}, {min(sizes[5:]):.0f} to {max(sizes[5:]):.0f}"
            yield f"memory of worker {name.rpartition(':')[2]}", good, told


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("items", type=int, nargs="?", default=12)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--engines", nargs="+", default=["local", "dask"], choices=["local", "dask"])
    parser.add_argument("--kill", nargs="+", default=["none", *DISTURBED], choices=["none", *DISTURBED])
    parser.add_argument("--seed", type=int, default=0, help="of the moments of killing")
    parser.add_argument("--fidelity", help="of the scenes, in place of their own")
    parser.add_argument("--tree", type=Path, help="instead of the palpation")
    parser.add_argument("--memory", type=int, default=0, help="items after which the memory of a worker is read again")
    parser.add_argument("--keep", type=Path, help="new folder for all rows")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = given.keep or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        bad = 0
        parts = [compared(given, folder)] + (
            [memory(folder, given.workers, given.memory, given.fidelity)] if given.memory else []
        )
        for part in parts:
            for what, good, told in part:
                bad += not good
                print(f"{'ok' if good else 'DIFFERS':8s}{what:34s} {told}", flush=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
