"""What each setting of the sheet is worth and what it costs: the table that the advisor predicts with.

    python benchmarks/sheet_tolerance.py [--presses 20] [--first 0] [--workers 1] [--keep FILE] [--write]

Bodies of each kind of top, sizes, depth and stretch drawn at random, are pressed by the settings of `fidelity/rungs.py`, with weight
and bending, and by one with elements two fifths as long that grow by 1.2. It prints, by what holds the membrane up and by range of
stretch, the 95th percentile of the error of force, height over the middle and length at four fifths of the depth; then the CPU time
of a press by setting, and how many times as long a press of the simulated cell takes with each effect. `--write` puts all of it into
the file that the advisor reads. Rows that `--keep` holds are not made again.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import statistics
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from kept import kept

import stretch_bt
from stretch_bt.accuracy.twin.press import press_once
from stretch_bt.accuracy.twin.press_tasks import (
    OBJECTS,
    REFERENCE,
    PressFigures,
    apart,
    pressed,
    scene_with,
    solved,
    warm,
)
from stretch_bt.errors import InvalidInput, NoAnswer, NoEquilibrium, SceneError
from stretch_bt.frames import Pose
from stretch_bt.runtime.provenance import processor
from stretch_bt.simulation.fidelity.rungs import RUNGS
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.world import World

FILE = Path(stretch_bt.__file__).parent / "simulation" / "advisor" / "data" / "sheet.json"
STRETCHES = (0.005, 0.03)  # m, where the second and the third range begin
RANGES = ((0.0, 0.0), (5.0, 30.0), (30.0, 80.0))  # mm, that stretches are drawn from; the first is slack
HOLDS = {
    "rim": ("box", "cylinder", "box", "cylinder", "wire_circle"),
    "crest": ("half_cylinder",),
    "ridge": ("prism",),
    "dome": ("sphere",),
    "point": ("cone", "cone", "pyramid"),
}
#: what is no sheet, by the kind of top that it has a closed form for
FORMS = {"hertz": {"dome": "sphere", "rim": "cylinder"}, "axisymmetric": {"dome": "sphere"}}
BASE = frozenset({"sag", "bending", "compliance"})
RESULTS = ("force", "height", "size")
_TRIES, _LEAST = 12, 20  # draws of a body at most, and presses of a percentile at least
#: effects, the set that each is added to, and the objects that have it
ADDED: Mapping[str, tuple[Collection[str], tuple[str, ...]]] = {
    "wrinkling": (BASE, ("sphere", "box")),
    "sag": ({"bending"}, ("sphere", "box")),
    "bending": ({"sag"}, ("sphere", "box")),
    "mullins": (BASE, ("sphere", "box")),
    "friction": (BASE, ("sphere", "box")),
    "compliance": ({"sag", "bending"}, ("balloon",)),
    "flattening": (BASE, ("balloon",)),
    "latex_softening": (BASE, ("balloon",)),
    "viscosity": (BASE, ("balloon",)),
    "granular_hysteresis": (BASE, ("balloon",)),
    "gas_compressibility": (BASE, ("balloon",)),
}


FILLS = {"viscosity": "pudding", "granular_hysteresis": "seeds", "gas_compressibility": "air"}


class Item(NamedTuple):
    """What is measured, on a body of a seed in a range of stretch: `errors` under a kind of top, `ms` of an object, or what an effect `costs`."""

    what: str
    of: str
    stretches: int
    seed: int


def body(kind: str, item: Item, attempt: int = 0) -> str:
    """Return the text of a scene of some kind, drawn at random."""
    random = np.random.default_rng([item.seed, item.stretches, list(OBJECTS).index(kind), attempt])
    stretch = random.uniform(*RANGES[item.stretches])
    return (
        "format: stretch-scene/1\n"
        f"object: {{{OBJECTS[kind](random)}}}\n"
        f"conditions: {{stretch: {stretch:.1f} mm, depth: {random.uniform(2.5, 16):.1f} mm, hold: 0.5 s, speed: 5 mm/s}}\n"
    )


def errors(item: Item) -> dict[str, Any]:
    """Return the errors of each setting in one press; a body without a press, or with too many elements, is drawn again."""
    kinds = HOLDS[item.of]
    for attempt in range(_TRIES):
        text = body(kinds[item.seed % len(kinds)], item, attempt)
        scene = scene_with(text, BASE)
        try:
            each = {rung: solved(scene, settings) for rung, settings in RUNGS.items()}
            known = solved(scene, REFERENCE)
        except (NoEquilibrium, InvalidInput):  # the reference's mesh has too many elements for some thin edges
            continue
        found = {rung: _sizes(one, known) for rung, one in each.items()}
        forms = {fidelity: kinds[item.of] for fidelity, kinds in FORMS.items() if item.of in kinds}
        formed = {fidelity: _formed(scene_with(body(kind, item), BASE), fidelity) for fidelity, kind in forms.items()}
        return {"text": text, "attempts": attempt + 1, "errors": found | formed}
    raise NoEquilibrium(f"none of {_TRIES} bodies has a press")


def _sizes(one: PressFigures, known: PressFigures) -> dict[str, float]:
    return {name: abs(value) for name, value in apart(one, known).items() if math.isfinite(value)}


def _formed(scene: Scene, fidelity: str) -> dict[str, float]:
    """Return the relative difference of a closed form's force from the sheet's."""
    pose, stretch = Pose((0.0, 0.0, scene.object.top - scene.conditions.depth)), scene.conditions.stretch
    forces = [math.hypot(*World(s).contact(pose, stretch).force) for s in (scene, scene.with_(fidelity=fidelity))]
    return {"force": abs(forces[1] / forces[0] - 1)}


def ms(item: Item) -> dict[str, Any]:
    """Return the CPU time of a press by each setting, ms, without effects."""
    scene = scene_with(body(item.of, item), ())
    return {"ms": {rung: 1e3 * min(pressed(scene, settings=s).cpu for _ in range(2)) for rung, s in RUNGS.items()}}


def costs(item: Item) -> dict[str, Any]:
    """Return how many times as long a press of the simulated cell takes with an effect."""
    on, kinds = ADDED[item.of]
    text = body(kinds[item.seed % len(kinds)], item)
    text = re.sub(r"fill: {type: \w+}", f"fill: {{type: {FILLS.get(item.of, 'water')}}}", text)
    with_, without = (min(_timed(scene_with(text, chosen)) for _ in range(2)) for chosen in ({*on, item.of}, set(on)))
    return {"times": with_ / without}


def _timed(scene: Scene) -> float:
    began = time.process_time()
    press_once(scene, 0)
    return time.process_time() - began


MEASURES: Mapping[str, Callable[[Item], dict[str, Any]]] = {"errors": errors, "ms": ms, "costs": costs}


def measured(*what: Any) -> dict[str, Any]:
    """Return a row; with a reason where there is no press."""
    item = Item(*what)
    warm()
    try:
        return {**item._asdict(), **MEASURES[item.what](item)}
    except (NoAnswer, SceneError) as error:
        return {**item._asdict(), "reason": str(error)[:200]}


def items(presses: int, first: int) -> Iterator[Item]:
    """Yield all measurements, by seed, so that a run that is broken off has some of each kind."""
    seeds = range(first, first + presses)
    ranges = range(len(RANGES))
    yield from (Item("errors", holds, k, seed) for seed in seeds for holds in HOLDS for k in ranges)
    few = seeds[: max(presses // 12, 1)]
    yield from (Item("ms", kind, k, seed) for seed in few for kind in ("sphere", "cone", "cylinder") for k in ranges)
    yield from (Item("costs", effect, k, seed) for seed in few for effect in ADDED for k in (0, 2))


def table(found: list[dict[str, Any]]) -> dict[str, Any]:
    """Return what the advisor reads."""
    good = [row for row in found if "reason" not in row]
    listed: dict[str, dict[str, list[dict[str, float]]]] = {}
    for rung in (*RUNGS, *FORMS):
        for holds in HOLDS:
            ranges = [
                [r for r in good if r["what"] == "errors" and r["of"] == holds and r["stretches"] == k]
                for k in range(len(RANGES))
            ]
            told = [_percentiles([r["errors"][rung] for r in each if rung in r["errors"]]) for each in ranges]
            if all(told):
                listed.setdefault(rung, {})[holds] = told
    times = {effect: [r["times"] for r in good if r["what"] == "costs" and r["of"] == effect] for effect in ADDED}
    factors = {effect: round(max(statistics.median(each), 1.0), 3) for effect, each in times.items() if each}
    presses = {rung: [_press_ms(good, rung, k) for k in range(len(RANGES))] for rung in RUNGS}
    about = {"made_by": "python benchmarks/sheet_tolerance.py --write", "processor": processor()}
    return {**about, "stretches": STRETCHES, "errors": listed, "press_ms": presses, "factors": factors}


def _percentiles(each: list[dict[str, float]]) -> dict[str, float]:
    told: dict[str, float] = {"n": len(each)} if each else {}
    for name in RESULTS:
        values = [row[name] for row in each if name in row]
        if values:
            told[name] = float(f"{np.percentile(values, 95):.3g}")
    return told


def _press_ms(good: list[dict[str, Any]], rung: str, stretches: int) -> float:
    times = [r["ms"][rung] for r in good if r["what"] == "ms" and r["stretches"] == stretches]
    return float(round(statistics.median(times), 1))


def show(made: Mapping[str, Any], found: list[dict[str, Any]]) -> None:
    """Print the table."""
    print(
        f"{'setting':13s} {'held by':8s} "
        + "  ".join(f"{low:g}-{high:g} mm: n, force %, height, size mm" for low, high in RANGES)
    )
    for rung, shapes in made["errors"].items():
        for holds, ranges in shapes.items():
            cells = [
                f"{r['n']:3d} {100 * r['force']:6.2f} {1e3 * r.get('height', math.nan):6.3f} {1e3 * r.get('size', math.nan):6.2f}"
                for r in ranges
            ]
            print(f"{rung:13s} {holds:8s} " + "        ".join(cells))
    print("ms of CPU a press:", json.dumps(made["press_ms"]))
    print("times as long with:", json.dumps(made["factors"]))
    failed = [row for row in found if "reason" in row]
    print(f"{len(found)} rows, {len(failed)} without an answer")


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--presses", type=int, default=_LEAST, help="of each kind of top in each range of stretch")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--keep", type=Path, help="file of rows, to begin or to go on with")
    parser.add_argument("--write", action="store_true", help=f"into {FILE.name} of the advisor")
    given = parser.parse_args()
    found = [row for _, row in kept(measured, items(given.presses, given.first), given.keep, given.workers)]
    made = table(found)
    show(made, found)
    least = min(row["n"] for shapes in made["errors"].values() for ranges in shapes.values() for row in ranges)
    if given.write and least < _LEAST:
        parser.error(f"a percentile needs {_LEAST} presses or more; ask for --presses {_LEAST}")
    if given.write:
        FILE.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
