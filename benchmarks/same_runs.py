"""Outputs and events of all shipped trees, to compare two versions of the code to the last digit.

Usage: python -m benchmarks.same_runs write FILE [TREE ...]
       python -m benchmarks.same_runs compare FILE OTHER

The first runs the shipped trees on three scenes and three seeds, and writes outputs, times and a digest of their commands, motions and faults.
The second prints each run in which two such files differ. A digest leaves out `owner`, the path of the node, which a tree may name anew,
and the ticks, which a loop may add.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import stretch_bt

SEEDS = (0, 1, 2)
SCENES = {
    "palpate_stiffness": ("water_balloon", "seeds_balloon", "pudding_balloon"),
    "palpate_active": ("water_balloon", "seeds_balloon", "pudding_balloon"),
    "reconstruct": ("wooden_cube", "wooden_half_cylinder", "wire_circle"),
    "watch_contact": ("water_balloon", "wooden_cube", "glass_snowman"),
    "form_cookie_fast": ("dough_cube",),
    "form_cookie": ("dough_cube",),
    "characterize": ("calibration_sphere",),
    "contact_sensitivity": ("calibration_cylinder",),
}
#: of trees that would run for hours
SHORTER: dict[str, dict[str, str]] = {
    "characterize": {
        "trials": "1",
        "diameters": "[20 mm, 30 mm]",
        "stretches": "[0 mm, 20 mm]",
        "depths": "[3 mm, 6 mm]",
    },
    "contact_sensitivity": {"diameters": "[20 mm, 30 mm]", "stretches": "[0 mm, 20 mm]", "depths": "[5 mm, 9 mm]"},
}
KEPT = ("command", "motion", "fault")


def cases(trees: list[str]) -> Iterator[tuple[str, str, int]]:
    """Yield each tree, scene and seed."""
    for tree in trees or SCENES:
        for scene in SCENES[tree]:
            for seed in SEEDS:
                yield tree, scene, seed


def events(record: Path) -> list[dict[str, Any]]:
    """Return the commands, motions and faults of a record, without owners and ticks."""
    found = []
    for line in (record / "events.jsonl").read_text(encoding="utf-8").splitlines():
        event = json.loads(line)
        if event["type"] in KEPT:
            found.append({name: value for name, value in event.items() if name not in ("owner", "tick", "time")})
    return found


def run(tree: str, scene: str, seed: int) -> dict[str, Any]:
    """Run one, and return what is compared."""
    with tempfile.TemporaryDirectory() as folder:
        record, begun = Path(folder) / "record", time.process_time()
        params = SHORTER.get(tree)
        result = stretch_bt.run(tree, scene=scene, seed=seed, out=record, params=params)
        kept = events(record)
        text = json.dumps(kept, sort_keys=True)
        return {
            "status": result.status,
            "reason": result.reason,
            "outputs": result.outputs,
            "ticks": result.ticks,
            "events": len(kept),
            "digest": hashlib.sha256(text.encode()).hexdigest(),
            "cpu": time.process_time() - begun,
        }


def write(file: Path, trees: list[str]) -> None:
    """Run all that the file does not hold yet."""
    found = json.loads(file.read_text()) if file.exists() else {}
    for tree, scene, seed in cases(trees):
        name = f"{tree} {scene} {seed}"
        if name not in found:
            found[name] = run(tree, scene, seed)
            file.write_text(json.dumps(found, indent=1))
            print(f"{name}: {found[name]['status']}, {found[name]['cpu']:.1f} s of CPU", flush=True)


def compare(first: Path, second: Path) -> int:
    """Print where two files differ, and return how many runs do."""
    one, other = (json.loads(file.read_text()) for file in (first, second))
    differing = 0
    for name in one.keys() & other.keys():
        unlike = [
            field
            for field in ("status", "reason", "outputs", "events", "digest", "ticks")
            if one[name][field] != other[name][field]
        ]
        differing += bool(unlike)
        for field in unlike:
            print(f"{name}: {field}: {one[name][field]} -> {other[name][field]}")
    print(f"{len(one.keys() & other.keys())} runs compared, {differing} differ")
    return differing


def main() -> None:
    """Write or compare."""
    command, *arguments = sys.argv[1:]
    if command == "compare":
        sys.exit(bool(compare(Path(arguments[0]), Path(arguments[1]))))
    write(Path(arguments[0]), arguments[1:])


if __name__ == "__main__":
    main()
