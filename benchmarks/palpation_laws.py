"""Palpation of own objects of four kinds of force law: bias, error over stated deviation, answers, presses and robot seconds.

    python benchmarks/palpation_laws.py [--objects 40] [--tree palpate_stiffness] [--hand drawn] [--hands FOLDER]
        [--set NAME=VALUE ...] [--keep FILE] [--workers 1]

Each seed draws an object of a class: a spring, an elastic ball (Hertz, power 1.5), a gel (power 1.2 to 1.8, a tenth to a half harder to a
sudden push, where the shipped pudding is 0.29 harder) or one of the four balloons,
with its own size, height and stiffness, 0.15 to 1.2 N/mm at 1.5 mm. The twin runs at sheet fidelity with what the
shipped scenes of balloons switch on. `--hand` chooses the force model's knowledge of the twin's hand:

    shipped  the shipped model, which states a deviation for any hand, and is not off in the twin
    known    the same hand, without doubt about it
    drawn    a hand that differs from the twin's by the shipped model's stated deviation, another one for each object
    measured hands that `python -m benchmarks.force_hands FOLDER` has pressed, with friction, softening, weight and bending, each known by a
             characterisation of it alone, with its noise; needs --hands FOLDER

Except with `shipped`, the arm misses its place by a random error of 0.05 mm, as is stated of it. Errors of `stiffness` are against the
scene's truth at the same instant, errors at 1.5 mm against the object's own law. --protocol before takes the prior and the last press of
earlier versions.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from kept import kept
from palpation_hands import cell_with, model_by, scene_with, true_hand

from stretch_bt.accuracy.palpation.palpated import PalpationTruth
from stretch_bt.accuracy.summary import rms
from stretch_bt.runtime.runner import Runner
from stretch_bt.runtime.task import run
from stretch_bt.simulation.objects.balloon import BalloonObject
from stretch_bt.simulation.objects.soft_sphere import SoftSphereObject
from stretch_bt.simulation.scene import load_scene

KINDS = ("spring", "hertz", "gel", "balloon")
HANDS = ("shipped", "known", "drawn", "measured")
SOFTEST, STIFFEST = 0.15, 1.2  # N/mm at 1.5 mm: from the paper's air to its seeds
#: kPa, range drawn from for each fill: about the shipped scene's pressure, so that each is a fifth off at most
PRESSURES = {"air": (1.6, 2.5), "water": (3.2, 5.0), "pudding": (3.2, 5.0), "seeds": (3.2, 5.0)}
BENCH = ("white_noise", "correlated_noise", "fixed_pattern", "drift", "quantisation", "dropout", "flying_pixels")
ARM_SD = "0.05 mm"
MODEL_ERROR = 0.005  # of a force, that a hand without doubt is still off: its table
BEFORE = {
    "power": 1.4,
    "power_sd": 0.12,
    "stiffening": 0.0,
    "stiffening_sd": 0.001,
    "last_deflection": 0.0015,
    "early_settle": 0.0,
    "settle": 1.5,
    "touches": 3,
    "touch_frames": 32,
}


def main() -> None:
    """Run what is not kept yet, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--objects", type=int, default=40, help="of each class")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=KINDS)
    parser.add_argument("--tree", default="palpate_stiffness")
    parser.add_argument("--hand", default="drawn", choices=HANDS)
    parser.add_argument("--hands", type=Path, help="folder of measured hands")
    parser.add_argument("--protocol", default="now", choices=("now", "before"))
    parser.add_argument("--set", nargs="*", default=[], help="params of the tree, NAME=VALUE")
    parser.add_argument(
        "--keep", type=Path, help="file of runs, one JSON object a line, which a later call goes on with"
    )
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    before = BEFORE if given.protocol == "before" else {}
    if given.tree != "palpate_stiffness":
        of_it = ("last_deflection", "early_settle", "settle", "touches", "touch_frames")
        before = {name: value for name, value in before.items() if name not in of_it}
    extra = {**before, **dict(pair.split("=", 1) for pair in given.set)}
    if (given.hand == "measured") != (given.hands is not None):
        parser.error("--hand measured and --hands FOLDER go together")
    hands = sorted(given.hands.glob("hand_*.npz")) if given.hands else []
    if given.hands and not hands:
        parser.error(f"{given.hands} holds no hand: make some by `python -m benchmarks.force_hands {given.hands}`")
    seeds = range(given.first, given.first + given.objects)
    calls = [
        (kind, seed, given.tree, hands[seed % len(hands)] if hands else given.hand, extra)
        for seed in seeds
        for kind in given.kinds
    ]
    report([row for _, row in kept(palpated, calls, given.keep, given.workers)], given.kinds)


def drawn_object(kind: str, seed: int) -> str:
    """Return an object of a class as a scene says it."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    diameter, base = rng.uniform(50, 70), rng.uniform(20, 40)
    if kind == "balloon":
        fill = sorted(PRESSURES)[seed % len(PRESSURES)]
        pressure = rng.uniform(*PRESSURES[fill])
        return f"{{type: balloon, diameter: {diameter:.2f} mm, base: {base:.2f} mm, pressure: {pressure:.3f} kPa, fill: {{type: {fill}}}}}"
    stiffness = math.exp(rng.uniform(math.log(SOFTEST), math.log(STIFFEST)))
    power = {"spring": 1.0, "hertz": 1.5, "gel": rng.uniform(1.2, 1.8)}[kind]
    gel = f", sudden: {rng.uniform(0.1, 0.5):.2f}, time: {rng.uniform(1.0, 3.0):.2f} s" if kind == "gel" else ""
    return (
        f"{{type: soft_sphere, diameter: {diameter:.2f} mm, base: {base:.2f} mm, stiffness: {stiffness:.4f} N/mm, "
        f"power: {power:.3f}{gel}}}"
    )


def scene_of(kind: str, seed: int, hand: str | Path) -> str:
    """Return the scene of an object, with what the shipped scenes of balloons switch on."""
    effects = "".join(f"\n  {name}: on" for name in BENCH)
    arm = f"\n  repeatability: {{sd: {ARM_SD}}}" if hand in ("known", "drawn") else ""
    scene = (
        f"format: stretch-scene/1\nobject: {drawn_object(kind, seed)}\n"
        "tolerance: {stiffness: 5 %, height: 0.3 mm}\n"
        "conditions: {stretch: 0 mm, depth: 15 mm, hold: 0.5 s, presses: 10, frames: 8}\n"
        f"effects:{effects}{arm}"
    )
    return scene + "\n" if isinstance(hand, str) else scene_with(scene, true_hand(hand))


def model_of(hand: str | Path, seed: int, folder: Path) -> str:
    """Return the force model of a run: the shipped one, or a file of one made from it or by a characterisation."""
    if isinstance(hand, Path):
        return model_by(folder, hand, seed)
    if hand == "shipped":
        return "membrane"
    model = json.loads((files("stretch_bt") / "model" / "data" / "default_membrane.json").read_text("utf-8"))
    if hand == "known":
        model["covariance"] = (1e-8 * np.array(model["covariance"])).tolist()
        model["relative_sd"] = MODEL_ERROR
    else:
        rng = np.random.default_rng([seed, len(KINDS)])
        sds = np.sqrt(np.diag(model["covariance"])) * rng.standard_normal(len(model["covariance"]))
        for (name, value), off in zip(model["hand"].items(), sds, strict=True):
            model["hand"][name] = abs(value + off)  # none of them is below 0
    path = folder / "hand.json"
    path.write_text(json.dumps(model), encoding="utf-8")
    return str(path)


def palpated(kind: str, seed: int, tree: str, hand: str | Path, params: dict[str, Any]) -> dict[str, Any]:
    """Return the numbers of a run on an own object."""
    notes: list[PalpationTruth] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = folder / "scene.yaml"
        scene.write_text(scene_of(kind, seed, hand), encoding="utf-8")
        spec = load_scene(scene).object
        assert isinstance(spec, BalloonObject | SoftSphereObject)

        def watch(runner: Runner) -> None:
            notes.append(PalpationTruth(runner, spec.top))
            runner.watchers.append(notes[0])

        cell = None if isinstance(hand, str) else cell_with(folder, true_hand(hand))
        given = {**params, "model": model_of(hand, seed, folder)}
        result = run(tree, watch=watch, scene=scene, seed=seed, params=given, out=folder / "record", cell=cell)
    row: dict[str, Any] = {"kind": kind, "seed": seed, "status": result.status, "reason": result.reason}
    if result.status != "SUCCESS":
        return row
    out, true = result.outputs, result.truth
    at = {"value": spec.secant() / 1e3}
    for key, name, truth in (("last", "stiffness", true["stiffness"]), ("at_drop", "stiffness_at_drop", at)):
        error, sd = out[name]["value"] / truth["value"] - 1, out[name]["sd"] / truth["value"]
        row[key] = {"error": error, "sd": sd}
    seen = notes[0]
    return {
        **row,
        "true": at["value"],
        "deflection": true["deflection"]["value"],
        "radius": out["radius"]["value"] / true["radius"]["value"] - 1,
        "presses": out["presses"]["value"],
        "seconds": out["robot_time"]["value"],
        "falls": seen.falls(),
        "heights": seen.errors,
        "cpu": result.cpu_seconds,
    }


def report(rows: list[dict[str, Any]], kinds: list[str]) -> None:
    """Print bias, rms error, error over stated and stated deviation of both stiffnesses, and what they took."""
    for row in rows:
        if row["status"] != "SUCCESS":
            print(f"{row['kind']}, seed {row['seed']}: {row['status']}: {row['reason']}")
    print(f"{'':8s}      {'stiffness at the last press':^32s} {'stiffness at 1.5 mm':^32s}")
    print(f"{'class':8s} {'ok':>7s}{2 * '    bias    rms  err/sd  stated'}   drop mm presses  robot s  falls")
    for kind in kinds:
        of_kind = [row for row in rows if row["kind"] == kind]
        good = [row for row in of_kind if row["status"] == "SUCCESS"]
        line = f"{kind:8s} {len(good):3d}/{len(of_kind):<3d}"
        if not good:
            print(line)
            continue
        for key in ("last", "at_drop"):
            error, sd = (np.array([row[key][n] for row in good]) for n in ("error", "sd"))
            line += f" {error.mean():7.1%} {rms(error):6.1%} {rms(error / sd):7.2f} {sd.mean():7.1%}"
        means = [float(np.mean([row[n] for row in good])) for n in ("deflection", "presses", "seconds")]
        print(f"{line} {means[0]:9.2f} {means[1]:7.1f} {means[2]:8.1f} {sum(row['falls'] for row in good):6d}")


if __name__ == "__main__":
    main()
