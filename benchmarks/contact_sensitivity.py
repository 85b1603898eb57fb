"""How well flat cylinders are felt over depth and stretch: python -m benchmarks.contact_sensitivity [--help]

Runs `contact_sensitivity` in the twin over seeds, by default with all noise of the bench camera; `--auto` leaves to the advisor what is on.
Prints for each way of measuring the share of the grid that is measured to below a millimetre, the refusals, the mean errors, and how
the absolute error goes with depth, stretch and diameter; then the maps. `--record` prints the same of tables that were written before.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stretch_bt import run
from stretch_bt.errors import NoAnswer
from stretch_bt.model.calibration.sensitivity import METHODS, NAME, Sensed, read_sensitivity
from stretch_bt.model.calibration.sensitivity_trends import ALONG, ErrorBin, cells_of, fine_share, mean_error, trend
from stretch_bt.units import Estimate

SCENE = "calibration_cylinder"
NOISY = """\
format: stretch-scene/1
doc: As calibration_cylinder, with all that the bench camera adds.
object: {type: cylinder, diameter: 20 mm, height: 60 mm, rim: 1 mm, rigid: true}
tolerance: {force: 3 %, height: 0.3 mm}
conditions: {stretch: 0 mm, depth: 15 mm, hold: 1 s, speed: 0 mm/s, frames: 24, presses: 15, travel: 0 mm}
effects:
  {white_noise: on, correlated_noise: on, fixed_pattern: on, drift: on, quantisation: on, dropout: on, flying_pixels: on, repeatability: on}
"""
MM = 1e3


def main() -> None:
    """Print what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1, help="how many, from 0")
    parser.add_argument("--auto", action="store_true", help="let the advisor decide what is on")
    for name, of in (("diameters", "10 to 30"), ("stretches", "0 to 60"), ("depths", "1 to 15")):
        parser.add_argument(f"--{name}", type=float, nargs="*", default=[], help=f"mm, in place of {of}")
    parser.add_argument("--hypothesis", default="auto", choices=["auto", "circle", "ellipse"])
    parser.add_argument(
        "--keep", type=Path, help="folder for the tables, with which an interrupted run is gone on with"
    )
    parser.add_argument("--record", type=Path, nargs="*", default=[], help="tables to print in place of runs")
    given = parser.parse_args()
    tables = given.record or [measured(seed, given) for seed in range(given.seeds)]
    presses = [press for table in tables for press in read_sensitivity(table).rows]
    print(f"{len(presses)} presses of {len(tables)} runs")
    for method in METHODS:
        told(method, presses)


def measured(seed: int, given: argparse.Namespace) -> Path:
    """Return the table of a run."""
    folder = given.keep or Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    scene, table = folder / f"{SCENE}.yaml", folder / f"seed_{seed}.csv"
    scene.write_text(NOISY, encoding="utf-8")
    params = {name: [v / MM for v in getattr(given, name)] for name in ("diameters", "stretches", "depths")}
    with tempfile.TemporaryDirectory() as record:
        result = run(
            "contact_sensitivity",
            scene=SCENE if given.auto else scene,
            seed=seed,
            params={**params, "table": str(table), "hypothesis": given.hypothesis},
            out=Path(record) / NAME.removesuffix(".csv"),
        )
    if result.status != "SUCCESS":
        raise SystemExit(f"seed {seed}: {result.status}: {result.reason}")
    seconds = result.outputs["robot_time"]["value"]
    print(
        f"seed {seed}: {result.outputs['presses']['value']} presses, {seconds:.0f} s of the robot, {result.cpu_seconds:.0f} s of CPU"
    )
    return table


def told(method: str, presses: Sequence[Sensed]) -> None:
    """Print what the maps of a method say, and the maps."""
    cells = cells_of(presses, method)
    share = fine_share(cells)
    refused = sum(cell.refused for cell in cells)
    print(
        f"\n{method}: below 1 mm in {share.value:.1%} +- {share.sd:.1%} of {len(cells)} places, {refused} presses refused"
    )
    for least in (0.0, 5e-3, 10e-3):
        print(f"  mean absolute error from {least * MM:g} mm of depth: {mean_of(presses, method, least)}")
    known = [abs(e) / max(sd, 1e-9) for e, sd in stated(presses, method)]
    if known:
        print(
            f"  error over its stated deviation: rms {np.sqrt(np.mean(np.square(known))):.2f}, median {np.median(known):.2f}"
        )
    for along in ALONG:
        print(f"  with {'diameter' if along == 'size' else along}: {trend_of(cells, along)}")
    for quantity in ("i", "j", "absolute"):
        printed(quantity, cells)


def mean_of(presses: Sequence[Sensed], method: str, least: float) -> str:
    try:
        return _shown(mean_error(presses, method, least), MM, "mm")
    except NoAnswer as error:
        return str(error)


def stated(presses: Sequence[Sensed], method: str) -> list[tuple[float, float]]:
    """Return errors along i and j with their stated deviations, m."""
    found = [(press, press.of(method)) for press in presses if not press.of(method).refused]
    return [pair for p, f in found for pair in ((f.i - p.size, f.i_sd), (f.j - p.size, f.j_sd))]


def trend_of(cells: Sequence[ErrorBin], along: str) -> str:
    try:
        found = trend(cells, along)
    except NoAnswer as error:
        return str(error)
    slope = f", slope {_shown(found.slope, 1.0, 'mm a mm')}" if found.slope is not None else ""
    return f"rank correlation {_shown(found.rank, 1.0, '')}over {found.groups} groups{slope}"


def printed(quantity: str, cells: Sequence[ErrorBin]) -> None:
    """Print the maps of a quantity, mm: depths down, stretches across, a map a diameter."""
    places = {(c.size, c.stretch, c.depth): getattr(c, quantity) for c in cells}
    sizes, stretches, depths = (sorted({getattr(c, name) for c in cells}) for name in ("size", "stretch", "depth"))
    title = "absolute error" if quantity == "absolute" else f"error along {quantity}"
    print(f"  {title}, mm: depth down; diameters {', '.join(f'{s * MM:g}' for s in sizes)} mm, each over the stretches")
    for depth in depths:
        row = ["".join(f"{_cell(places.get((s, x, depth))):>7}" for x in stretches) for s in sizes]
        print(f"  {depth * MM:5.1f} |{' |'.join(row)}")


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value * MM:.2f}"


def _shown(value: Estimate | float, scale: float, unit: str) -> str:
    error = f" +- {value.sd * scale:.3f}" if isinstance(value, Estimate) else ""
    return f"{float(value) * scale:.3f}{error} {unit}"


if __name__ == "__main__":
    main()
