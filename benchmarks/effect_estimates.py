"""The advisor's estimate of each effect of membrane and object against the twin with everything on, and with everything on but it.

    python benchmarks/effect_estimates.py [press] [--scenes 40] [--first 5000] [--workers 1] [--keep FILE]
    python benchmarks/effect_estimates.py stiffness [--scenes 6] [--first 5000] [--workers 1] [--keep FILE]

`press` presses random bodies and balloons that no estimate was fitted to, all with the sheet's settings for 1 %. It prints,
by effect and result, the estimate over what the effect changed: the median, the extremes, how many are within a factor of two, and how
many have the stated sign. A change below a tenth of the usual tolerance (3 % of force, 0.3 mm of height, 1 mm of size) is left out where its
estimate is below a third of it; so are estimates of effects that remember earlier presses, since there were none.
`stiffness` palpates random balloons without noise, everything on but effects that remember (friction and softening, which is added alone).
"""

from __future__ import annotations

import argparse
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from kept import kept

import stretch_bt
from stretch_bt.accuracy.twin.press_tasks import (
    OBJECTS,
    apart,
    drawn,
    possible,
    pressed,
    scene_with,
    with_effects,
)
from stretch_bt.errors import NoAnswer, SceneError
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.choose import judge
from stretch_bt.simulation.scene import parse_scene

USUAL = {"force": 0.03, "height": 0.3e-3, "size": 1e-3, "stiffness": 0.05}
KINDS = ("sphere", "cone", "box", "cylinder", "balloon", "prism", "half_cylinder", "wire_circle")
WITHIN = 0.01  # of the force, that the sheet is solved to
PALPATED = (
    "tolerance: {stiffness: 5 %, height: 0.3 mm}\nconditions: {stretch: 0 mm, depth: 15 mm, hold: 0.5 s, presses: 10}\n"
)
REMEMBERING = ("friction", "mullins")


def of_press(seed: int) -> dict[str, Any]:
    """Return, by effect, what leaving it off takes from a press with everything on."""
    random = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    text = drawn(random, kind)
    try:
        every = set(possible(text))
        known = pressed(scene_with(text, every), within=WITHIN)
        changes = {
            name: apart(known, pressed(scene_with(text, every - {name}), within=WITHIN)) for name in sorted(every)
        }
    except (NoAnswer, SceneError) as error:
        return {"seed": seed, "kind": kind, "text": text, "reason": str(error)[:200]}
    return {"seed": seed, "kind": kind, "text": text, "changes": changes}


def of_palpation(seed: int) -> dict[str, Any]:
    """Return, by effect, how much leaving it off takes from the stiffness that palpation measures on a balloon."""
    text = f"format: stretch-scene/1\nobject: {{{OBJECTS['balloon'](np.random.default_rng(seed))}}}\n{PALPATED}"
    try:
        every = set(possible(text)) - set(REMEMBERING)
        known = _stiffness(text, every, seed)
        changes = {
            name: {"stiffness": known / _stiffness(text, every - {name}, seed) - 1}
            for name in sorted(every - {"compliance"})
        }
        changes["friction"] = {"stiffness": _stiffness(text, {*every, "friction"}, seed) / known - 1}
    except (NoAnswer, SceneError) as error:
        return {"seed": seed, "kind": "balloon", "text": text, "reason": str(error)[:200]}
    return {"seed": seed, "kind": "balloon", "text": text, "changes": changes}


def _stiffness(text: str, on: set[str], seed: int) -> float:
    """Return the stiffness, N/mm, that palpation measures; raises NoAnswer where it measures none."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(with_effects(text, on), encoding="utf-8")
        found = stretch_bt.run("palpate_stiffness", scene=path, seed=seed, out=Path(folder) / "record")
    if found.status != "SUCCESS":
        raise NoAnswer(found.reason)
    return float(found.outputs["stiffness"]["value"])


def show(found: list[dict[str, Any]]) -> None:
    """Print estimates over changes."""
    shares: dict[tuple[str, str], list[tuple[float, bool]]] = {}
    for row in (r for r in found if "changes" in r):
        scene = parse_scene(row["text"])
        judged = judge(scene, Case(scene, scene.object.rough()))
        for effect, changes in row["changes"].items():
            for name, change in changes.items():
                size = judged[effect].sizes.get(name)
                estimate = 0.0 if size is None else size.value
                small = abs(change) < USUAL[name] / 10 and estimate < USUAL[name] / 3
                if not small and math.isfinite(change):
                    signed = size is None or size.way == 0 or size.way * change > 0
                    shares.setdefault((effect, name), []).append((estimate / max(abs(change), 1e-12), signed))
    print(f"{'effect':20s} {'result':9s} {'n':>3s} {'median':>7s} {'least':>7s} {'most':>8s}  within 2   sign")
    for (effect, name), each in sorted(shares.items()):
        values, signs = np.array([v for v, _ in each]), sum(s for _, s in each)
        near = int(((values > 0.5) & (values < 2)).sum())
        print(
            f"{effect:20s} {name:9s} {len(each):3d} {np.median(values):7.2f} {values.min():7.2f} {values.max():8.2f}  "
            f"{near:3d} of {len(each):3d} {signs:3d}"
        )
    every = np.array([v for each in shares.values() for v, _ in each])
    print(f"all: {int(((every > 0.5) & (every < 2)).sum())} of {len(every)} within a factor of two")
    for row in (r for r in found if "reason" in r):
        print(f"seed {row['seed']}, {row['kind']}: {row['reason']}")


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", nargs="?", choices=("press", "stiffness"), default="press")
    parser.add_argument("--scenes", type=int)
    parser.add_argument("--first", type=int, default=5000, help="first seed")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--keep", type=Path, help="file of rows, to begin or to go on with")
    given = parser.parse_args()
    scenes = given.scenes or (40 if given.what == "press" else 6)
    calls = [(seed,) for seed in range(given.first, given.first + scenes)]
    work = of_press if given.what == "press" else of_palpation
    show([row for _, row in kept(work, calls, given.keep, given.workers)])


if __name__ == "__main__":
    main()
