"""Tasks over all four wires, many seeds: how each ended, its errors over the stated ones, and the stand-ins' share of a core.

Run with `python benchmarks/wired_tasks.py TASK[:SCENE] ... [--seeds 0-19] [--model ur] [--at-once N] [--times K] [--keep FILE]`. Each run has
stand-ins and a cell of its own; `--times` runs the task so often on one cell, each time on a new object, from wherever the run before left
the hand. Rows that FILE has are not run again. The truth of a stiffness comes from the simulated cell, which follows the commands of the
wired run.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from wired_cell import wired_cell

import stretch_bt
from stretch_bt.clock import VirtualClock
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.simulation.scene import load_scene

Row = dict[str, Any]
#: what is compared with the scene, where both have it
COMPARED = ("stiffness", "force", "deflection")


def one(task: str, scene: str, seed: int, model: str, times: int) -> Iterator[Row]:
    """Yield a row for each run of a task on one cell."""
    with tempfile.TemporaryDirectory() as name, wired_cell(Path(name), scene, seed, model=model) as cell:
        for k in range(times):
            if k > 0:
                cell.servers.renew()
            result, cores = cell.run(task, seed, f"{name}/{k}")
            late = cell.servers.stand_ins["realsense"].state()
            truth = followed(scene, seed, Path(name) / str(k)) if result.status == "SUCCESS" else {}
            yield {
                "task": task,
                "scene": scene,
                "seed": seed,
                "model": model,
                "time": k,
                "status": result.status,
                "reason": result.reason,
                "seconds": result.task_seconds,
                "overruns": result.overruns,
                "cores": sum(cores.values()),
                "sent": late["sent"],
                "late": late["late"],
                "outputs": result.outputs,
                "truth": truth,
            }


def followed(scene: str, seed: int, record: Path) -> dict[str, float]:
    """Return the scene's truth at the end of a task, SI: a simulated cell is given the recorded commands at their times."""
    events = [json.loads(line) for line in (record / "events.jsonl").read_text().splitlines()]
    sent = [e for e in events if e.get("type") == "command" and e["device"] in ("arm", "gripper")]
    while "/finally" in sent[-1]["owner"]:
        end = sent.pop()["time"]
    clock = VirtualClock()
    cell = open_cell(load_cell("simulated"), now=clock.now, seed=seed, scene=load_scene(scene))
    try:
        for event in sent:
            clock.advance(max(event["time"] - clock.now(), 0.0))
            repeat(cell.devices[event["device"]], event["name"], event["arguments"])
        clock.advance(max(end - clock.now(), 0.0))
        return cell.truth()
    finally:
        cell.close()


def repeat(device: Any, name: str, arguments: Mapping[str, Any]) -> None:
    """Give a recorded command again."""
    given = {**arguments, "owner": "benchmark"}
    for key in ("target", "path"):
        if key in given:
            poses = [given[key]] if key == "target" else given[key]
            made = [Pose(tuple(p["position"]), tuple(p["rotation"])) for p in poses]
            given[key] = made[0] if key == "target" else made
    device.stop() if name == "stop" else getattr(device, name)(**given)


def jobs(args: argparse.Namespace, kept: list[Row]) -> list[list[str]]:
    """Return the arguments of the runs that are still to be done."""
    first, _, last = args.seeds.partition("-")
    have = {(row["task"], row["scene"], row["seed"], row["model"]) for row in kept}
    found = []
    for name in args.tasks:
        task, _, scene = name.partition(":")
        scene = (
            scene or yaml.safe_load((Path(stretch_bt.__file__).parent / "trees" / f"{task}.yaml").read_text())["scene"]
        )
        for seed in range(int(first), int(last or first) + 1):
            if (task, scene, seed, args.model) not in have:
                found.append([task, scene, str(seed), args.model, str(args.times)])
    return found


def done(waiting: list[list[str]], at_once: int) -> Iterator[Row]:
    """Yield the rows of some runs at once, each in a process of its own."""
    running: list[tuple[list[str], subprocess.Popen[str]]] = []
    while waiting or running:
        while waiting and len(running) < at_once:
            job = waiting.pop(0)
            command = [sys.executable, __file__, "--one", *job]
            running.append((job, subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)))
        job, process = running.pop(0)
        said, wrong = process.communicate()
        rows = [json.loads(line) for line in said.splitlines() if line.startswith("{")]
        yield from rows
        if not rows:
            task, scene, seed, model, _ = job
            reason = (wrong.strip().splitlines() or ["it said nothing"])[-1]
            yield {
                "task": task,
                "scene": scene,
                "seed": int(seed),
                "model": model,
                "status": "BROKEN",
                "reason": reason,
            }


def told(row: Row) -> str:
    """Return one line of a row."""
    head = f"{row['task']:20s}{row['scene']:18s}{row['model']:6s}{row['seed']:3d} {row['status']:9s}"
    if "cores" not in row:
        return f"{head}{row['reason']}"
    scores = ", ".join(f"{name} {score:+.2f}" for name, score in scored(row).items())
    return f"{head}{row['seconds']:6.1f} s, {row['cores']:.2f} cores, {row['late']}/{row['sent']} late, {scores} {row['reason']}"


def scored(row: Row) -> dict[str, float]:
    """Return errors over what was stated, by output."""
    units = {"stiffness": 1e3, "force": 1.0, "deflection": 1e-3}
    outputs, truth = row.get("outputs", {}), row.get("truth", {})
    both = [name for name in COMPARED if name in outputs and name in truth and outputs[name].get("sd")]
    return {name: (outputs[name]["value"] - truth[name] / units[name]) / outputs[name]["sd"] for name in both}


def summed(rows: list[Row]) -> Iterator[str]:
    """Yield a line for each task and scene."""
    for task, scene, model in dict.fromkeys((r["task"], r["scene"], r["model"]) for r in rows):
        mine = [r for r in rows if (r["task"], r["scene"], r["model"]) == (task, scene, model)]
        good = [r for r in mine if r["status"] == "SUCCESS"]
        line = f"{task} on {scene}, {model}: {len(good)} of {len(mine)} SUCCESS"
        if good:
            line += f", {statistics.median(r['cores'] for r in good):.2f} cores (at most {max(r['cores'] for r in good):.2f})"
        for name in COMPARED:
            scores = [s[name] for r in good if name in (s := scored(r))]
            if scores:
                rms = math.sqrt(statistics.fmean(s * s for s in scores))
                line += f"; {name} error over stated {rms:.2f} (mean {statistics.fmean(scores):+.2f}, largest {max(map(abs, scores)):.1f})"
        yield line


def main() -> int:
    """Run, and return 1 where a run did not end as SUCCESS."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="+")
    parser.add_argument("--seeds", default="0")
    parser.add_argument("--model", default="ur", choices=("ur", "ur5e"))
    parser.add_argument("--at-once", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--one", action="store_true", help="one run: task, scene, seed, model, times")
    args = parser.parse_args()
    if args.one:
        task, scene, seed, model, times = args.tasks
        for row in one(task, scene, int(seed), model, int(times)):
            print(json.dumps(row), flush=True)
        return 0
    kept = [json.loads(line) for line in args.keep.read_text().splitlines()] if args.keep and args.keep.exists() else []
    for row in done(jobs(args, kept), args.at_once):
        print(told(row), flush=True)
        kept.append(row)
        if args.keep:
            with args.keep.open("a") as file:
                file.write(json.dumps(row) + "\n")
    print("\n".join(summed(kept)))
    return int(any(row["status"] != "SUCCESS" for row in kept))


if __name__ == "__main__":
    sys.exit(main())
