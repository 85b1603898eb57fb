"""Palpation of the four balloons by hands that no force model knows: stiffness against the scene's truth, and their order.

    python -m benchmarks.force_hands FOLDER --hands 25
    python benchmarks/palpation_hands.py FOLDER [--seeds 100] [--tree palpate_stiffness] [--keep FILE] [--plot FILE]

Each seed takes a hand of the folder (of its own thickness, modulus and pre-stretch, half of them Mooney-Rivlin, with friction and
softening), draws the noise of a characterisation of it, fits the membrane model to that, and palpates the four balloons with that
model at sheet fidelity, with the noise of the bench camera, of the arm and of the force sensor. The hand was conditioned before, as its
characterisation does it. Runs are kept in the file that --keep names, so that a long run can be taken up again.

The rate at which two balloons come in their order follows from the measured errors at 1.5 mm of drop: each balloon gets a neighbour that is
stiffer by a ratio, felt by the same hand with the error that its real neighbour had.
"""

from __future__ import annotations

import argparse
import tempfile
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml
from kept import kept

import stretch_bt
from stretch_bt.accuracy.force.hands import ROBOT, STRETCHES, TrueHand, measured
from stretch_bt.accuracy.palpation.figures import DROP, figures
from stretch_bt.accuracy.palpation.palpated import watched
from stretch_bt.accuracy.palpation.protocols import BALLOONS
from stretch_bt.accuracy.summary import rms
from stretch_bt.model.calibration.calibrate_membrane import fit_membrane

Array = npt.NDArray[np.float64]

RATIOS = np.array([1.06, 1.1, 1.15, 1.2, 1.3, 1.4, 1.5, 1.75, 2.0])
SCENES = Path(stretch_bt.__file__).parent / "trees" / "scenes"
NEEDED = 1.3  # ratio of neighbours from which on the order is to be right


def main() -> None:
    """Print the table of the balloons, the order of all four, and the rate of order by ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--tree", default="palpate_stiffness")
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    hands = sorted(given.folder.glob("hand_*.npz"))
    seeds = range(given.first, given.first + given.seeds)
    calls = [(hands[seed % len(hands)], given.tree, balloon, seed) for seed in seeds for balloon in BALLOONS]
    report([row for _, row in kept(palpated, calls, given.keep, given.workers)], len(hands), given.plot)


def palpated(hand: Path, tree: str, balloon: str, seed: int) -> dict[str, Any]:
    """Return the numbers of a run by a hand whose model knows a characterisation of it alone."""
    true = true_hand(hand)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene, cell = _scene(folder, balloon, true), cell_with(folder, true)
        params, out = {"model": model_by(folder, hand, seed)}, folder / "record"
        result, seen = watched(balloon, tree, scene=scene, cell=cell, seed=seed, params=params, out=out)
    row = {"seed": seed, "hand": hand_seed(hand), "balloon": balloon, "status": result.status, "reason": result.reason}
    if result.status != "SUCCESS":
        return row
    value = result.outputs["stiffness_at_drop"]["value"]
    return {**row, "figures": figures(result, seen, balloon), "at_drop": value, "cpu": result.cpu_seconds}


def hand_seed(hand: Path) -> int:
    """Return the seed of the hand whose forces a file holds."""
    return int(hand.stem[-3:])


def true_hand(hand: Path) -> TrueHand:
    """Return the hand whose forces a file holds."""
    return TrueHand.drawn(hand_seed(hand))


def model_by(folder: Path, hand: Path, seed: int) -> str:
    """Return the file of a force model that a characterisation of a hand, with the noise of a seed, gives."""
    path = folder / "hand.json"
    fit_membrane(measured(np.load(hand)["force"], seed), None).save(path)
    return str(path)


def _scene(folder: Path, balloon: str, hand: TrueHand) -> Path:
    """Return a balloon's scene with a drawn hand."""
    shipped = (SCENES / f"{balloon}_balloon.yaml").read_text("utf-8").rstrip()  # which ends with its effects
    path = folder / "scene.yaml"
    path.write_text(scene_with(shipped, hand), encoding="utf-8")
    return path


def scene_with(scene: str, hand: TrueHand) -> str:
    """Return a scene that ends with its effects, with a drawn hand that was conditioned before and what acts on it."""
    effects = [f"friction: {{coefficient: {hand.friction}}}", f"mullins: {{share: {hand.softening}}}"]
    effects += [f"{name}: on" for name in ("sag", "bending", "force_sensor_noise")]
    effects += [f"repeatability: {{sd: {ROBOT} m}}"]
    return (
        "\n  ".join((scene, *effects))
        + f"""
hand:
  shear_modulus: {hand.shear_modulus} Pa
  second_invariant: {hand.share}
  mount_prestretch: {hand.mount_prestretch} m
  conditioned: {{diameter: 60 mm, stretch: {STRETCHES[-1]} m, depth: 15 mm}}
"""
    )


def cell_with(folder: Path, hand: TrueHand) -> Path:
    """Return the simulated cell with the thickness of a drawn hand."""
    cell = yaml.safe_load((SCENES.parent / "cells" / "simulated.yaml").read_text("utf-8"))
    cell["hand"]["thickness"] = f"{hand.thickness} m"
    path = folder / "cell.yaml"
    path.write_text(yaml.safe_dump(cell, sort_keys=False), encoding="utf-8")
    return path


def report(rows: list[dict[str, Any]], hands: int, plot: Path | None) -> None:
    """Print what the runs say."""
    for row in rows:
        if row["status"] != "SUCCESS":
            print(f"seed {row['seed']}, {row['balloon']}: {row['status']}: {row['reason']}")
    good = {(r["seed"], r["balloon"]): r for r in rows if r["status"] == "SUCCESS"}
    seeds = sorted({seed for seed, _ in good})
    print(f"{len(seeds)} seeds, {hands} hands")
    print(
        "balloon      ok    bias    rms  err/sd  at drop: bias    rms  err/sd  height sd, mm  presses  robot s  falls"
    )
    for balloon in BALLOONS:
        e = np.array([good[s, balloon]["figures"] for s in seeds if (s, balloon) in good], dtype=float).T
        print(
            f"{balloon:10s} {e.shape[1]:4d} {e[0].mean():7.1%} {rms(e[0]):6.1%} {rms(e[1]):7.2f} {e[2].mean():14.1%} {rms(e[2]):6.1%} "
            f"{rms(e[3]):7.2f} {rms(e[6]):14.3f} {e[7].mean():8.1f} {e[8].mean():8.1f} {e[10].sum():6.0f}"
        )
    every = [s for s in seeds if all((s, b) in good for b in BALLOONS)]
    told = np.array([[good[s, b]["at_drop"] for b in BALLOONS] for s in every])
    right = np.all(np.diff(told, axis=1) > 0, axis=1).sum()
    print(f"order of all four at {DROP * 1e3:g} mm of drop: right in {right} of {len(rows) // len(BALLOONS)} seeds")
    off = np.log1p(np.array([[good[s, b]["figures"][2] for b in BALLOONS] for s in every]))
    _rates(off, plot)


def _rates(off: Array, plot: Path | None) -> None:
    """Print and draw how often neighbours come in order by their ratio; `off` (seeds, 4), logarithms of measured over true."""
    gains = np.concatenate([off[:, j] - off[:, i] for i, j in pairwise(range(off.shape[1]))])
    rates = [float(np.mean(gains + np.log(ratio) > 0)) for ratio in RATIOS]
    print("ratio of neighbours   " + "  ".join(f"{r:5.2f}" for r in RATIOS))
    print("in their order, %     " + "  ".join(f"{100 * r:5.1f}" for r in rates))
    if plot is not None:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(5, 3.5), layout="constrained")
        axes = figure.subplots()
        fine = np.geomspace(1.0, 2.0, 200)
        axes.plot(fine, [100 * np.mean(gains + np.log(ratio) > 0) for ratio in fine], lw=1)
        axes.plot(RATIOS, 100 * np.array(rates), "o", ms=4)
        axes.axvline(NEEDED, color="gray", lw=0.5)
        axes.set(xlabel="ratio of their stiffness", ylabel="pairs in their order, %", ylim=(45, 101))
        figure.savefig(plot, dpi=120)


if __name__ == "__main__":
    main()
