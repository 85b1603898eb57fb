"""Kinds and sizes found for prisms of many outlines: is an answer of a wrong kind far from the outline, and which are refused?

    python -m benchmarks.outline_kinds [--seeds 1] [--stretch 25] [--depth 10] [--only NAME]

Prisms are pressed in the sheet solver (edges of 1 mm, 25 mm of stretch, 10 mm deep) and seen with noise: none, white of 0.3 and 1 mm, and
smooth of 1 mm, eight frames averaged. For each frame the kind that `measure_contact` finds, its widths, mm, and `off`: how far the
outline that it finds lies from the true one at most, over the standard deviation of half its widths. The table at the end counts right kinds,
wrong ones within 5 deviations and beyond, and refusals, by kind of outline and noise.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter, defaultdict
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.noise import CLEAN, CORRELATED, WHITE_03, WHITE_10, Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, BodyPress, seen
from stretch_bt.errors import NoAnswer, NoEquilibrium
from stretch_bt.perception import deproject, measure_contact, to_membrane
from stretch_bt.perception.size.result import ContactSize
from stretch_bt.perception.smooth import smooth
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron

Array = npt.NDArray[np.float64]
NOISES = {"none": CLEAN, "white 0.3": WHITE_03, "white 1": WHITE_10, "smooth 1": CORRELATED}
MM = 1e3
FAR = 5.0  # stated deviations
EDGE = 1e-3  # m


def polygon(corners: int, radius: float, heading: float = 0.2) -> Array:
    """Return the corners (n, 2), m, of a regular polygon, `radius` from its middle in the mean of all directions."""
    mean = math.log((1 + math.sin(math.pi / corners)) / (1 - math.sin(math.pi / corners))) / (2 * math.pi / corners)
    at = heading + 2 * math.pi * np.arange(corners) / corners
    return radius / mean / math.cos(math.pi / corners) * np.column_stack([np.cos(at), np.sin(at)])


def ellipse(long: float, short: float, heading: float = 0.0) -> Array:
    """Return the corners (48, 2), m, of an ellipse of two widths, its long axis at a heading from i, rad."""
    at = 2 * math.pi * np.arange(48) / 48
    return _turned(np.column_stack([long / 2 * np.cos(at), short / 2 * np.sin(at)]), heading)


def rectangle(length: float, width: float, corner: float = 0.0, heading: float = 0.0) -> Array:
    """Return the corners (n, 2), m, of a rectangle whose corners are round by a radius, m."""
    signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    middles = signs * (np.array([length, width]) / 2 - corner)
    if corner == 0.0:
        return _turned(middles.astype(float), heading)
    at = [
        m + corner * np.array([math.cos(a), math.sin(a)])
        for k, m in enumerate(middles)
        for a in math.pi / 2 * (k + np.linspace(0, 1, 7))
    ]
    return _turned(np.array(at), heading)


def _turned(places: Array, heading: float) -> Array:
    c, s = math.cos(heading), math.sin(heading)
    return np.column_stack([c * places[:, 0] - s * places[:, 1], s * places[:, 0] + c * places[:, 1]])


def outlines() -> dict[str, tuple[str, Array]]:
    """Return outlines by name: of what kind, and corners (n, 2), m, counter-clockwise."""
    found: dict[str, tuple[str, Array]] = {}
    for n in range(3, 13):
        found[f"{n} corners"] = ("rectangle" if n == 4 else "neither", polygon(n, 10e-3))
    for width in (5, 10, 14.31, 20, 30):
        found[f"circle {width:g}"] = ("circle", ellipse(width / MM, width / MM))
    for aspect in (1.1, 1.25, 1.5, 2.0):
        for turn in (0, 40):
            size = 18e-3 * math.sqrt(aspect)
            found[f"ellipse {aspect:g} at {turn}"] = (
                "ellipse" if turn == 0 else "neither",
                ellipse(size, size / aspect, math.radians(turn)),
            )
    for corner in (0, 2, 4, 6):
        found[f"square 18 round {corner}"] = ("rectangle", rectangle(18e-3, 18e-3, corner / MM, 0.3))
        found[f"rectangle 22 x 14 round {corner}"] = ("rectangle", rectangle(22e-3, 14e-3, corner / MM, 0.0))
    return found


def prism(corners: Array, height: float = 0.04, edge: float = EDGE) -> Polyhedron:
    """Return an upright prism with rounded edges, its top at 0."""
    n = len(corners)
    vertices = np.concatenate([np.column_stack([corners, np.full(n, z)]) for z in (0.0, -height)])
    faces = [(0, k, k + 1) for k in range(1, n - 1)]
    faces += [(n + a, n + c, n + b) for a, b, c in faces]
    for k in range(n):
        after = (k + 1) % n
        faces += [(k, n + k, n + after), (k, n + after, after)]
    return Polyhedron(vertices, np.array(faces), edge)


def radii(corners: Array, angles: Array, edge: float = 0.0) -> Array:
    """Return how far an outline through corners (n, 2), m, is from their middle at angles (m,), m; its corners are round by an edge, m."""
    ends = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([ends[:, 1], -ends[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    away = (normals * corners).sum(axis=1) - edge
    before = np.roll(np.arange(len(corners)), 1)
    pairs = np.stack([normals[before], normals], axis=1)
    core = np.linalg.solve(pairs, np.stack([away[before], away], axis=1)[..., None])[..., 0]
    at = np.linspace(0.0, 2 * math.pi, 1440, endpoint=False)
    towards = np.stack([np.cos(at), np.sin(at)])
    reach = (core @ towards).max(axis=0) + edge
    cosines = np.cos(at[:, None] - angles)
    return np.asarray(np.where(cosines > 1e-6, reach[:, None] / np.maximum(cosines, 1e-6), np.inf).min(axis=0))


def told_radii(size: ContactSize, angles: Array) -> Array | None:
    """Return the same for the outline that a measurement finds; None for a free form, which has its widths alone."""
    if size.shape in ("circle", "ellipse"):
        i, j = size.diameter_i / 2, size.diameter_j / 2
        return np.asarray(1.0 / np.hypot(np.cos(angles) / i, np.sin(angles) / j))
    if size.sides is None or size.rotation is None:
        return None
    return radii(rectangle(*size.sides, heading=size.rotation), angles)


def off(size: ContactSize, corners: Array) -> float:
    """Return how far the outline that a measurement finds is from the true one, over the deviation of half its widths."""
    stated = max(size.diameter_i_sd, size.diameter_j_sd, *(size.sides_sd or ())) / 2
    angles = np.linspace(0.0, 2 * math.pi, 360, endpoint=False)
    told = told_radii(size, angles)
    if told is None:
        angles = np.array([0.0, math.pi / 2])
        told = np.array([size.diameter_i, size.diameter_j]) / 2
    return float(np.abs(told - radii(corners, angles, EDGE)).max()) / stated


def measured(press: BodyPress, noise: Noise, seed: int, fillet_sd: float = 0.1e-3) -> ContactSize:
    """Return the size of a press seen with noise; labels are what the smoothed height shows, as a segmentation has them."""
    points, valid = deproject(observe(seen(press), noise, seed))
    points = to_membrane(points, PLANE_DISTANCE)
    height, _ = smooth(np.where(valid, points[..., 2], 0.0).astype(np.float32), valid.astype(np.float32), 6.0)
    labels = np.where(valid, np.where(height > 0.85 * height.max(), 2, 1), 255).astype(np.uint8)
    return measure_contact(points, labels, stretch=press.stretch, fillet_sd=fillet_sd)


def outcomes(name: str, kind: str, corners: Array, press: BodyPress, seeds: int) -> Iterator[tuple[str, str]]:
    """Print the answers on an outline, and yield noise and outcome of each frame."""
    for noise, made in NOISES.items():
        for seed in range(1 if noise == "none" else seeds):
            try:
                size = measured(press, made, seed)
            except (NoAnswer, NoEquilibrium) as error:
                print(f"{name:26} {noise:9} refused: {str(error)[:80]}", flush=True)
                yield noise, "refused"
                continue
            far = off(size, corners)
            widths = f"{MM * size.diameter_i:6.2f} +- {MM * size.diameter_i_sd:.2f} x {MM * size.diameter_j:6.2f} +- {MM * size.diameter_j_sd:.2f}"
            others = " ".join(f"{k} {v:.0f}" for k, v in size.evidence.items())
            print(f"{name:26} {noise:9} {size.shape:10} {widths}  off {far:5.1f}   {others}", flush=True)
            right = size.shape == kind or size.shape == "free_form" or (kind == "circle" and size.shape == "ellipse")
            yield noise, "right" if right else "wrong, near" if far < FAR else "wrong, far"


def main() -> None:
    """Print a line for each frame, and the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--stretch", type=float, default=25, help="mm")
    parser.add_argument("--depth", type=float, default=10, help="mm")
    parser.add_argument("--only", default="", help="outlines whose name begins so")
    given = parser.parse_args()
    table: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for name, (kind, corners) in outlines().items():
        if not name.startswith(given.only):
            continue
        body = Cylinder(2 * float(corners[0, 0])) if kind == "circle" else prism(corners)
        press = BodyPress(body, given.stretch / MM, given.depth / MM, mesh=1e-3)
        try:
            for noise, outcome in outcomes(name, kind, corners, press, given.seeds):
                table[kind, noise][outcome] += 1
        except NoEquilibrium as error:
            print(f"{name:26} not pressed: {error}")
    for (kind, noise), counts in sorted(table.items()):
        print(f"{kind:10} {noise:10} " + ", ".join(f"{n} {what}" for what, n in sorted(counts.items())))


if __name__ == "__main__":
    main()
