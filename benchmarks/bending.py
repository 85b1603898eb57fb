"""The advisor's estimate of bending against sheets solved with it and without, under random bodies.

    python benchmarks/bending.py [check] [--bodies 100] [--first 1000] [--keep FILE]
    python benchmarks/bending.py fit [--bodies 140] [--first 0] [--keep FILE]

Each body has a kind, sizes, a heading, a hand and a press drawn at random. `check` prints, by result and kind, the estimate over what
bending changed: the median, the extremes, and how many are within a factor of 1.5. A change below a tenth of the usual tolerance
(3 % of force, 0.3 mm of height, 1 mm of size) is left out where its estimate is below a third of it. `fit` prints the laws of
`simulation/effects/bending.py` as least squares of logarithms find them; it takes other bodies than `check` does.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from kept import kept

from stretch_bt.accuracy.twin.press import length_at
from stretch_bt.errors import NoEquilibrium, SceneError
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.bending import Bending
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.indenters.turned import turn
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.simulation.scene import Scene, parse_scene

TOLERANCES = {"force": 0.03, "height": 0.3e-3, "size": 1e-3}
KINDS = {
    "cylinder": 0.22,
    "box": 0.22,
    "cone": 0.15,
    "sphere": 0.11,
    "prism": 0.09,
    "half_cylinder": 0.09,
    "pyramid": 0.06,
    "wire_circle": 0.03,
    "wire_triangle": 0.03,
}
TOP, HIGH, POINTS = (
    2e-3,
    0.8,
    361,
)  # m round the middle that counts as top, share of the depth, points along each side of the sheet
MEMBRANE = (0.100, 0.090, 0.002)  # m: gauge, width, thickness


class Row(NamedTuple):
    """A scene's text and what bending changes: part of the force, m of the height, m of the length at four fifths of the depth."""

    kind: str
    text: str
    changes: dict[str, float]


def drawn(random: np.random.Generator) -> tuple[str, str]:
    """Return the kind of a random body, and its scene."""
    kind, u = str(random.choice(list(KINDS), p=list(KINDS.values()))), random.uniform
    options = {
        "cylinder": lambda: f"diameter: {u(8, 60):.1f} mm, height: 60 mm, rim: {u(0.3, 2.5):.2f} mm",
        "box": lambda: (
            f"length: {u(10, 60):.1f} mm, width: {u(10, 50):.1f} mm, height: 60 mm, edge: {u(0.3, 2.5):.2f} mm"
        ),
        "cone": lambda: (
            f"angle: {u(15, 60):.1f} deg, height: 60 mm, tip: {math.exp(u(math.log(0.5), math.log(8))):.2f} mm"
        ),
        "sphere": lambda: f"diameter: {u(10, 80):.1f} mm",
        "prism": lambda: (
            f"length: {u(20, 60):.1f} mm, width: {u(25, 60):.1f} mm, height: {u(20, 40):.1f} mm, edge: {u(0.5, 2):.2f} mm"
        ),
        "half_cylinder": lambda: f"diameter: {u(15, 70):.1f} mm, length: {u(15, 60):.1f} mm",
        "pyramid": lambda: f"width: {u(30, 60):.1f} mm, height: {u(15, 40):.1f} mm, edge: {u(0.5, 2):.2f} mm",
        "wire_circle": lambda: f"diameter: {u(30, 60):.1f} mm, thickness: {u(1.5, 4):.1f} mm, base: 20 mm",
        "wire_triangle": lambda: f"side: {u(35, 60):.1f} mm, thickness: {u(1.5, 4):.1f} mm, base: 20 mm",
    }[kind]()
    rigid = "" if kind.startswith("wire") else ", rigid: true"
    stretch = 0.0 if random.random() < 0.5 else u(0, 60)
    return kind, (
        "format: stretch-scene/1\n"
        f"object: {{type: {kind}, {options}{rigid}, heading: {u(-90, 90):.0f} deg}}\n"
        f"hand: {{mount_prestretch: {u(6, 20):.1f} mm, shear_modulus: {u(30, 80):.0f} kPa}}\n"
        "tolerance: {height: 0.3 mm, size: 1 mm, force: 3 %}\n"
        f"conditions: {{stretch: {stretch:.1f} mm, depth: {u(4, 16):.1f} mm}}\n"
    )


def changes(scene: Scene, body: Indenter | Several | None = None) -> dict[str, float]:
    """Return what bending changes in the press of a scene, on the body of its object or another, where it is seen."""
    (force, height, size), (bent, higher, wider) = (
        _pressed(scene, body or scene.object.body(), bending) for bending in (False, True)
    )
    found = {"force": bent / force - 1, "height": higher - height, "size": wider - size}
    return {name: change for name, change in found.items() if math.isfinite(change)}  # a shallow one has no such length


def _pressed(scene: Scene, body: Indenter | Several | None, bending: bool) -> tuple[float, float, float]:
    """Return force, N, height of the middle and length at four fifths of the depth, m."""
    hand, use = scene.hand, scene.conditions
    assert body is not None
    sheet = Sheet(*MEMBRANE, hand.material(), hand.mount_prestretch, Effects(bending=bending))
    found = solve(
        sheet, Load(turn(body, scene.object.heading), use.stretch, use.depth, (0.0, 0.0), (0.0, 0.0)), Settings()
    )
    points = found.shape.points(POINTS, POINTS).reshape(-1, 3)
    top = points[np.hypot(points[:, 0], points[:, 1]) < TOP, 2].mean()
    return float(found.force[2]), float(top), length_at(points, HIGH * use.depth)


def rows(first: int, count: int, keep: Path | None) -> Iterator[Row]:
    """Yield what bending changes for bodies from a seed on; bodies that a file holds are not solved again."""
    for (seed,), (kind, text, changed, why) in kept(_changed, [(first + k,) for k in range(count)], keep):
        if why:
            print(f"seed {seed}, {kind}: {why}")
        else:
            yield Row(kind, text, changed)


def _changed(seed: int) -> tuple[str, str, dict[str, float], str]:
    """Return the kind and the scene of a body, the changes by bending, and the reason where there are none."""
    kind, text = drawn(np.random.default_rng(seed))
    try:
        return kind, text, changes(parse_scene(text)), ""
    except (NoEquilibrium, SceneError) as error:
        return kind, text, {}, str(error)


def check(found: list[Row]) -> None:
    """Print the estimates over what they estimate."""
    shares: dict[tuple[str, str], list[float]] = {}
    for row in found:
        case = _case(row)
        told: dict[str, float] = {size.observable: size.value for size in Bending.sizes(case, None)}
        for name, change in row.changes.items():
            estimate, tolerance = told.get(name, 0.0), TOLERANCES[name]
            if abs(change) > 0.1 * tolerance or estimate > 0.3 * tolerance:
                shares.setdefault((name, row.kind), []).append(estimate / change)
    print(f"{'result':8s} {'body':14s} {'bodies':>6s} {'median':>7s} {'least':>7s} {'most':>7s}  within 1.5")
    for (name, kind), values in sorted(shares.items()):
        _line(name, kind, np.array(values))
    for name in TOLERANCES:
        _line(name, "all", np.array([v for (of, _), values in shares.items() if of == name for v in values]))


def _line(name: str, kind: str, values: Any) -> None:
    near = ((values > 1 / 1.5) & (values < 1.5)).sum()
    print(
        f"{name:8s} {kind:14s} {len(values):6d} {np.median(values):7.2f} {values.min():7.2f} {values.max():7.2f}  {near} of {len(values)}"
    )


def fit(found: list[Row]) -> None:
    """Print the law of each result by what holds the membrane up: its value at 2, 10 and 10 mm, and its powers of layer, contact and depth."""
    print(
        f"{'result':8s} {'held by':8s} {'bodies':>6s} {'there':>9s} {'bend':>6s} {'contact':>8s} {'depth':>6s}  rms factor"
    )
    for name in TOLERANCES:
        for holds in ("rim", "crest", "ridge", "dome", "point"):
            known = [(_case(row), row.changes.get(name, 0.0)) for row in found]
            kept = [(case, change) for case, change in known if case.rough.holds == holds and change > 0]
            if len(kept) < 6:
                continue
            aspect = np.array([case.rough.aspect if name == "height" else 1.0 for case, _ in kept])
            wanted = np.log(np.array([change for _, change in kept]) / aspect)
            design = np.array([[1.0, *(math.log(v) for v in _places(case))] for case, _ in kept])
            law = np.linalg.lstsq(design, wanted, rcond=None)[0]
            left = math.exp(float(np.std(wanted - design @ law)))
            print(
                f"{name:8s} {holds:8s} {len(kept):6d} {math.exp(law[0]):9.3g} {law[1]:6.2f} {law[2]:8.2f} {law[3]:6.2f}  {left:.2f}"
            )


def _places(case: Case) -> tuple[float, float, float]:
    layer = math.sqrt(4 * case.scene.hand.shear_modulus * case.thickness**3 / 12 / case.tension)
    return layer / 2e-3, case.held_radius / 10e-3, case.depth / 10e-3


def _case(row: Row) -> Case:
    scene = parse_scene(row.text)
    return Case(scene, scene.object.rough())


def main() -> None:
    """Print what was asked for."""
    asks: dict[str, tuple[Callable[[list[Row]], None], int, int]] = {"check": (check, 1000, 100), "fit": (fit, 0, 140)}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", nargs="?", choices=asks, default="check")
    parser.add_argument("--bodies", type=int)
    parser.add_argument("--first", type=int)
    parser.add_argument("--keep", type=Path, help="file of rows, to begin or to go on with")
    given = parser.parse_args()
    print_, first, count = asks[given.what]
    first = first if given.first is None else given.first
    print_(list(rows(first, given.bodies or count, given.keep)))


if __name__ == "__main__":
    main()
