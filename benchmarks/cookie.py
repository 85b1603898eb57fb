"""Cookies that both trees make from drawn cubes of dough; rows are kept, and a run can be taken up again.

    python benchmarks/cookie.py --keep FILE [--trees form_cookie form_cookie_fast] [--seeds 0-49] [--spin 0] [--table]

Each seed's lump is fixed: edge 20 to 30 mm, yield stress 2 to 10 kPa (log-uniform), modulus 10 to 30 yield stresses, spin noise 0
to 0.2, edge cracks 0 to 2 %. The scene is `dough_cube` with these numbers, the effects that the advisor switches on, and beside
them spin noise, cracks, and the noise of camera and arm: with the tolerance of the scene the advisor would leave that off, and
the stop rules read it. Parameters were set on seeds from 1000 on; seed 0 taught that the depth must be bounded.

`time to 0.97`: of rolling, until the outline that the lump would be pressed to has a low-pass circularity of 0.97, as a mean over
12 axes, which a cube does not have over any axis. Runs that end in FAILURE before the stop count with the bound.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Iterable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from kept import kept

from stretch_bt import run
from stretch_bt.accuracy.cookie.lumps import draw, scene
from stretch_bt.errors import NoEquilibrium
from stretch_bt.perception.outlines.polyline import area_of, perimeter_of
from stretch_bt.perception.outlines.roundness import METHODS, contour_of
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.runner import Runner
from stretch_bt.simulation.dough.disc import outline
from stretch_bt.simulation.dough.lump import Lump

AXES = 12
ROUND, POOR = 0.97, 0.93
PAPER, FAST = "form_cookie", "form_cookie_fast"
SENSED = {
    "circularity_sensed": "circularity_true",
    "pixel_chain": "pixel_chain_true",
    "thickness": "thickness_true",
}
BOUNDS = {PAPER: 120.0, FAST: 78.0}  # s of rolling: so many readings, or looks, so far apart


class Watch(Onlooker):
    """Follows a run: when the lump got round while it rolled, and how it stood when rolling ended."""

    def __init__(self) -> None:
        self.reached: float | None = None
        self.at_stop: dict[str, float] = {}
        self.rolled = 0.0

    def follow(self, runner: Runner) -> None:
        """Watch a run."""
        self.twin: Any = runner.cell._context.twin  # type: ignore[union-attr]
        runner.watchers.append(self)

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Look at the lump whenever the time of rolling is written."""
        if not key.endswith("rolling_time"):
            return
        self.rolled = float(value)
        try:
            self.twin.contact(self.twin.now())
        except NoEquilibrium:
            return
        past = self.twin.world._past[-1]
        lump: Lump = past.thing.rolled
        self.at_stop = {"spread": lump.roundness, "low_pass": low_pass(lump), "mean": all_round(lump)}
        if self.reached is None and self.at_stop["mean"] >= ROUND:
            self.reached = self.rolled


def all_round(lump: Lump) -> float:
    """Return the mean circularity of the outlines to which a lump would be pressed along axes all round it."""
    index = np.arange(AXES)
    z = 1 - (index + 0.5) / AXES
    azimuth, across = index * math.pi * (3 - math.sqrt(5)), np.sqrt(1 - z**2)
    axes = np.column_stack([across * np.cos(azimuth), across * np.sin(azimuth), z])
    return float(np.mean([low_pass(_along(lump, axis)) for axis in axes]))


def _along(lump: Lump, axis: Any) -> Lump:
    """Return a lump turned so that an axis of its own stands upright."""
    up = np.array([0.0, 0.0, 1.0])
    quaternion = np.array([1 + axis @ up, *np.cross(axis, up)])
    return replace(lump, quaternion=quaternion / np.linalg.norm(quaternion))


def low_pass(lump: Lump) -> float:
    """Return the low-pass circularity of the outline to which a lump would be pressed as it lies, without its error."""
    curve = METHODS["low_pass"](contour_of(outline(lump, lump.ball)))
    return 4 * math.pi * area_of(curve) / perimeter_of(curve) ** 2


def made(tree: str, seed: int, spin: float | None = None) -> dict[str, Any]:
    """Return the row of a run."""
    lump, watch = draw(seed), Watch()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(scene(lump, spin), encoding="utf-8")
        result = run(tree, scene=path, seed=seed, out=Path(folder) / "record", watch=watch.follow)
    outputs = {name: out["value"] for name, out in result.outputs.items()}
    truth = {name: out["value"] for name, out in result.truth.items()}
    return {
        "tree": tree,
        "seed": seed,
        "spun": spin,
        **asdict(lump),
        "status": result.status,
        "reason": result.reason,
        "outputs": outputs,
        "sds": {name: out["sd"] for name, out in result.outputs.items()},
        "thickness_true": truth.get("thickness"),
        "rolled": watch.rolled,
        "reached": watch.reached,
        "at_stop": watch.at_stop,
        "task_seconds": result.task_seconds,
        "cpu_seconds": result.cpu_seconds,
    }


def seeds(text: str) -> list[int]:
    """Return the seeds of `0-49` or `3,7`."""
    parts = [part.split("-") for part in text.split(",")]
    return [k for part in parts for k in range(int(part[0]), int(part[-1]) + 1)]


def main() -> None:
    """Run what is missing, keep each row, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--trees", nargs="*", default=[PAPER])
    parser.add_argument("--seeds", type=seeds, default=seeds("0-49"))
    parser.add_argument("--spin", type=float)
    parser.add_argument("--table", action="store_true", help="print the table of the rows that are kept, run nothing")
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    calls = [(tree, seed, given.spin) for seed in given.seeds for tree in given.trees]
    rows = []
    for _, row in kept(made, calls, given.keep, given.workers, call=not given.table):
        rows.append(row)
        print(line(row), flush=True)
    for tree in given.trees:
        print(table(tree, [r for r in rows if r["tree"] == tree]))


def line(row: dict[str, Any]) -> str:
    """Return a row as text."""
    stop, out = row["at_stop"], row["outputs"]
    return (
        f"{row['tree']:17s} {row['seed']:4d}  edge {1e3 * row['edge']:.1f} mm  Y {row['yield_stress'] / 1e3:.1f} kPa  E/Y "
        f"{row['modulus'] / row['yield_stress']:.0f}  {row['status']:8s} rolled {row['rolled']:6.1f} s  round after {row['reached']}  "
        f"spread {stop.get('spread', math.nan):.3f}  low-pass {out.get('low_pass_true', math.nan):.3f}  contour "
        f"{out.get('circularity_true', math.nan):.3f}  sensed {out.get('circularity_sensed', math.nan):.3f}  "
        f"{row['cpu_seconds']:.1f} CPU s  {row['reason'][:90]}"
    )


def table(tree: str, rows: list[dict[str, Any]]) -> str:
    """Return the figures of a tree."""
    if not rows:
        return f"\n{tree}: no rows"
    good = [r for r in rows if r["status"] == "SUCCESS"]
    stops = [r for r in rows if r["at_stop"] and (r["status"] == "SUCCESS" or "stiff" in r["reason"])]
    rolled = [r["rolled"] if r in stops else BOUNDS[tree] for r in rows]
    reached = [math.inf if r["reached"] is None else r["reached"] for r in rows]
    low = [r["outputs"]["low_pass_true"] for r in good]
    spread = [r["at_stop"]["spread"] for r in stops]
    unround = sum(r["at_stop"]["low_pass"] < POOR for r in stops)
    lines = [f"\n{tree}: {len(rows)} runs, {len(good)} cookies"]
    for name in (
        "circularity_true",
        "low_pass_true",
        "pixel_chain_true",
        "edge_roughness",
        "circularity_sensed",
        "pixel_chain",
    ):
        lines.append(f"  mean {name:20s} {_mean(r['outputs'].get(name) for r in good)}")
    for name, true in SENSED.items():
        lines.append(f"  error of {name:19s} {_errors(good, name, true)}")
    lines += [
        f"  cookies under {POOR} low-pass    {sum(v < POOR for v in low)} of {len(good)}",
        f"  radius sd over mean at the stop  {_quantiles(spread, (50, 90))} (median, 90th percentile; {len(stops)} stops)",
        f"  rolling time, s                  {_quantiles(rolled, (50, 90))}, mean {_mean(rolled)}",
        f"  time to {ROUND}, s                 {_quantiles(reached, (25, 50, 75))} (quartiles; inf: never while it rolled)",
        f"  stops under {POOR} low-pass      {unround} of {len(stops)}",
        f"  CPU s                            {_quantiles([r['cpu_seconds'] for r in rows], (50, 100))} (median, most)",
        f"  task s                           {_quantiles([r['task_seconds'] for r in rows], (50, 100))} (median, most)",
    ]
    for reason in sorted({r["reason"] for r in rows if r["status"] != "SUCCESS"}):
        at = [r for r in rows if r["status"] != "SUCCESS" and r["reason"] == reason]
        ratios = ", ".join(f"{r['seed']} (E/Y {r['modulus'] / r['yield_stress']:.0f})" for r in at)
        lines.append(f"  {len(at)} x {at[0]['status']}: {reason}: seeds {ratios}")
    return "\n".join(lines)


def _errors(rows: list[dict[str, Any]], name: str, true: str) -> str:
    """Return the error of a sensed value, and the error over its stated deviation."""
    pairs = [(r["outputs"].get(name), r["outputs"].get(true, r.get(true)), r.get("sds", {}).get(name)) for r in rows]
    found = np.array([(told - known, sd) for told, known, sd in pairs if None not in (told, known, sd)]).reshape(-1, 2)
    if not len(found):
        return "-"
    off, over = found[:, 0], np.abs(found[:, 0]) / found[:, 1]
    rms = float(np.sqrt(np.mean(over**2)))
    return f"{off.mean():+.4f} +- {off.std():.4f}, over stated: rms {rms:.2f}, most {over.max():.1f}"


def _mean(values: Iterable[float | None]) -> str:
    found = [v for v in values if v is not None]
    if not found:
        return "-"
    error = np.std(found, ddof=1) / math.sqrt(len(found)) if len(found) > 1 else math.nan
    return f"{np.mean(found):.4f} +- {error:.4f}, least {min(found):.4f}"


def _quantiles(values: Iterable[float], parts: tuple[int, ...]) -> str:
    found = sorted(values)
    if not found:
        return "-"
    method: Any = "linear" if math.isfinite(found[-1]) else "lower"
    return ", ".join(f"{np.percentile(found, p, method=method):.3f}" for p in parts)


if __name__ == "__main__":
    main()
