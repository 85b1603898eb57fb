"""Whether a press that asks for a tolerance stays within it, and the cost of its choice beside the cheapest one that does.

    python benchmarks/tolerance_held_out.py [press] [--tasks 60] [--priced 20] [--first 9300] [--workers 1] [--keep FILE]
    python benchmarks/tolerance_held_out.py palpation [--percent 2 5] [--seeds 8] [--workers 1] [--keep FILE]

`press`: random spheres, cones, boxes and balloons under stretches of 0 to 80 mm, pressed straight down without noise, each with a
tolerance of the force from 0.5 to 10 % and `fidelity: auto`; no table or law was made from them. The error of the force is
against a press with everything on and the finest setting, corrected, under rigid bodies, by what elements half as long change with
weight and bending. Tasks that have no such press, or whose tolerance is refused, are drawn again. For the first `--priced` tasks every
cheaper choice of setting and effects, by the committed table of costs, is pressed too, until one is within the tolerance: the ratio is
the cost of the advisor's choice over the cost of the cheapest choice that is.
`palpation`: water_balloon and seeds_balloon by `palpate_stiffness --tolerance stiffness=P%`, and with everything on, on paired seeds: the mean
difference of the stiffness beside each P, once two standard errors of it are below that; else it is not shown.
"""

from __future__ import annotations

import argparse
import math
import statistics
import tempfile
from importlib.resources import files
from itertools import chain, combinations
from pathlib import Path
from typing import Any

import numpy as np
from kept import kept

import stretch_bt
from stretch_bt.accuracy.twin.press_tasks import REFERENCE, PressFigures, drawn, possible, pressed, scene_with, solved
from stretch_bt.errors import NoAnswer, SceneError
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.choose import NOISE, Chosen, choose
from stretch_bt.simulation.advisor.sheet_table import read_sheet_table
from stretch_bt.simulation.effects import registry
from stretch_bt.simulation.fidelity.rungs import RUNGS
from stretch_bt.simulation.scene import Scene, parse_scene
from stretch_bt.simulation.scene.sections import Tolerance

KINDS = ("sphere", "cone", "box", "balloon")
PERCENT = (0.5, 10.0)
TRIES = 20
FINEST = list(RUNGS)[-1]
BALLOONS = ("water_balloon", "seeds_balloon")


def asking(text: str, part: float) -> Scene:
    """Return a scene without noise that leaves the rest to the advisor, for a run that asks for a tolerance of the force."""
    off = ", ".join(f"{name}: off" for name, effect in registry().items() if effect.group in NOISE)
    bare = "\n".join(line for line in text.splitlines() if not line.startswith("tolerance"))
    return parse_scene(f"{bare}\nfidelity: auto\neffects: {{{off}}}\n").tolerating(
        Tolerance.model_validate({"force": part})
    )


def press_task(seed: int, priced: bool) -> dict[str, Any]:
    """Return what came of the task of a seed."""
    refused = []
    for attempt in range(TRIES):
        random = np.random.default_rng([seed, attempt])
        kind = KINDS[seed % len(KINDS)]
        text, part = drawn(random, kind), random.uniform(*PERCENT) / 100
        chosen = choose(asking(text, part))
        if not chosen.reached:
            refused.append(f"{kind}, {100 * part:.2f} %: {100 * chosen.predicted['force'].value:.2f} % is the best")
            continue
        try:
            known = everything(text)
        except (NoAnswer, SceneError) as failure:
            refused.append(str(failure)[:100])
            continue
        found = _pressed(text, chosen.rung or FINEST, chosen.on)
        error = math.inf if found is None else abs(found.force / known.force - 1)
        row = {"seed": seed, "kind": kind, "text": text, "tolerance": part, "error": error, "refused": refused}
        told = chosen.predicted["force"]
        row |= {
            "predicted": told.value,
            "total": told.total,
            "rung": chosen.rung,
            "on": sorted(chosen.on),
            "cost": chosen.cost_ms,
        }
        return {**row, **(_priced(text, part, known, chosen) if priced else {})}
    return {"seed": seed, "reason": "; ".join(refused)}


def everything(text: str) -> PressFigures:
    """Return a press with everything on; raises NoEquilibrium."""
    known = pressed(scene_with(text, possible(text)), settings=RUNGS[FINEST])
    bare = scene_with(text, {"sag", "bending"})
    if math.isfinite(bare.object.rough().stiffness):
        return known
    finer = solved(bare, REFERENCE).force / solved(bare, RUNGS[FINEST]).force
    return known._replace(force=known.force * finer)


def _pressed(text: str, rung: str, on: frozenset[str] | set[str]) -> PressFigures | None:
    try:
        return pressed(scene_with(text, on), settings=RUNGS[rung])
    except NoAnswer:
        return None


def _priced(text: str, part: float, known: PressFigures, chosen: Chosen) -> dict[str, Any]:
    """Return the cheapest choice within the tolerance, by trying all that are cheaper than the one chosen, the cheapest first."""
    scene, table = parse_scene(text), read_sheet_table()
    case, able = Case(scene, scene.object.rough()), possible(text)
    sets = [set(on) for on in chain.from_iterable(combinations(able, k) for k in range(len(able) + 1))]
    whole = [on for on in sets if all(registry()[name].needs in {None, *on} for name in on)]
    choices = sorted(
        ((table.cost(rung, on, case), rung, sorted(on)) for rung in RUNGS for on in whole), key=lambda c: c[:2]
    )
    tried = 0
    for cost, rung, on in choices:
        if cost >= chosen.cost_ms:
            break
        tried += 1
        found = _pressed(text, rung, set(on))
        if found is not None and abs(found.force / known.force - 1) <= part:
            return {"cheapest": cost, "cheapest_rung": rung, "cheapest_on": on, "tried": tried}
    return {"cheapest": chosen.cost_ms, "cheapest_rung": chosen.rung, "cheapest_on": sorted(chosen.on), "tried": tried}


def show_presses(found: list[dict[str, Any]]) -> None:
    """Print a line for each task, the share within the tolerance and the ratios of cost."""
    print("seed kind    tolerance predicted (plain sum) error    setting, effects; cheapest by cost")
    good = [row for row in found if "reason" not in row]
    for row in good:
        cheap = (
            f"; {row['cost'] / row['cheapest']:.2f} of {row['cheapest_rung']} {', '.join(row['cheapest_on'])}"
            if "cheapest" in row
            else ""
        )
        print(
            f"{row['seed']} {row['kind']:8s} {100 * row['tolerance']:6.2f} % {100 * row['predicted']:6.2f} % ({100 * row['total']:6.2f} %) "
            f"{100 * row['error']:6.2f} %{'' if row['error'] <= row['tolerance'] else ' <- over'}  {row['rung']} {', '.join(row['on'])}{cheap}"
        )
    within = sum(row["error"] <= row["tolerance"] for row in good)
    refused = sum(len(row.get("refused", ())) for row in good)
    share = 100 * within / max(len(good), 1)
    print(
        f"{within} of {len(good)} within the tolerance, {share:.1f} %; {refused} draws refused, {len(found) - len(good)} seeds without a task"
    )
    ratios = [row["cost"] / row["cheapest"] for row in good if "cheapest" in row and row["error"] <= row["tolerance"]]
    if ratios:
        mean, middle, over = statistics.fmean(ratios), statistics.median(ratios), sum(r > 1.5 for r in ratios)
        print(
            f"cost over the cheapest, {len(ratios)} tasks: mean {mean:.2f}, median {middle:.2f}, largest {max(ratios):.2f}, {over} over 1.5"
        )


def palpated(name: str, seed: int, percents: list[float]) -> dict[str, Any]:
    """Return the results of palpating a scene with the choice of each tolerance of the stiffness, and with everything on."""
    text = (files("stretch_bt") / "trees" / "scenes" / f"{name}.yaml").read_text("utf-8")
    every = "".join(f"  {effect}: on\n" for effect in possible(text))
    with tempfile.TemporaryDirectory() as folder:
        full = Path(folder) / "everything.yaml"
        full.write_text(text.rstrip() + "\n" + every, encoding="utf-8")
        chosen = {f"{percent:g}": _told(Path(folder), name, seed, {"stiffness": percent / 100}) for percent in percents}
        return {
            "scene": name,
            "seed": seed,
            "chosen": chosen,
            "everything": _told(Path(folder), str(full), seed, None),
        }


def _told(folder: Path, scene: str, seed: int, asked: dict[str, float] | None) -> dict[str, Any]:
    """Return the stiffness that a palpation measures, N/m, its deviation and CPU time, s, or why there is none."""
    try:
        out = folder / f"{asked}"
        found = stretch_bt.run("palpate_stiffness", scene=scene, seed=seed, out=out, tolerance=asked)
    except SceneError as refused:
        return {"reason": str(refused)}
    told = found.outputs.get("stiffness", {}) if found.status == "SUCCESS" else {}
    return {
        "value": told.get("value"),
        "sd": told.get("sd"),
        "cpu_seconds": found.cpu_seconds,
        "reason": found.reason,
    }


def show_palpations(found: list[dict[str, Any]], percents: list[float]) -> None:
    """Print the mean difference of each scene beside each tolerance, and the deviation that the estimator states."""
    for name in BALLOONS:
        every = [row for row in found if row["scene"] == name]
        for percent in percents:
            _show_pairs(name, percent, [(row["chosen"][f"{percent:g}"], row["everything"]) for row in every])


def _show_pairs(name: str, percent: float, every: list[tuple[dict[str, Any], dict[str, Any]]]) -> None:
    pairs = [(one, other) for one, other in every if one.get("value") and other.get("value")]
    if len(pairs) < 2:
        reasons = {side["reason"] for pair in every for side in pair if not side.get("value")}
        print(f"{name}, {percent:g} %: not shown, {len(pairs)} pairs; {'; '.join(map(str, reasons))}")
        return
    off = [100 * (one["value"] / other["value"] - 1) for one, other in pairs]
    mean, error = statistics.fmean(off), statistics.stdev(off) / math.sqrt(len(off))
    verdict = "not shown: more seeds" if 2 * error >= percent else "within" if abs(mean) <= percent else "over"
    sd = statistics.fmean(one["sd"] / one["value"] for one, _ in pairs if one["sd"])
    cpu = [statistics.median(side["cpu_seconds"] for side in sides) for sides in zip(*pairs, strict=True)]
    print(
        f"{name}: {mean:+.2f} % +- {error:.2f} % (standard error) of {percent:g} %, {len(pairs)} of {len(every)} pairs: {verdict}; "
        f"the estimator states {100 * sd:.1f} %; CPU {cpu[0]:.1f} s, with everything {cpu[1]:.1f} s"
    )


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", nargs="?", choices=("press", "palpation"), default="press")
    parser.add_argument("--tasks", type=int, default=60)
    parser.add_argument("--priced", type=int, default=20, help="of the tasks, for which every cheaper choice is tried")
    parser.add_argument("--first", type=int, default=9300, help="first seed of the tasks")
    parser.add_argument("--percent", type=float, nargs="+", default=[5.0], help="tolerances of the stiffness")
    parser.add_argument("--seeds", type=int, default=8, help="of a palpation")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--keep", type=Path, help="file of rows, to begin or to go on with")
    given = parser.parse_args()
    if given.what == "press":
        tasks = [(given.first + k, k < given.priced) for k in range(given.tasks)]
        show_presses([row for _, row in kept(press_task, tasks, given.keep, given.workers)])
    else:
        runs = [(name, seed, given.percent) for seed in range(given.seeds) for name in BALLOONS]
        show_palpations([row for _, row in kept(palpated, runs, given.keep, given.workers)], given.percent)


if __name__ == "__main__":
    main()
