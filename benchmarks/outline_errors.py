"""Errors of the outline of a contact, and of a level line, over what is stated.

    python benchmarks/outline_errors.py [--seeds 12] [--first 0] [--shapes SHAPE ...] [--level MM]

Balls, cylinders, blocks and ovals with fillets of 0.7 to 2 mm are pressed into the sheet solver (elements of 0.6 mm), 2 to 12 mm deep, pulled by
3 to 60 mm, one in five not at all, half of the sheets bending, off the middle and leaning by 1.5 degrees; the noise is a shipped
camera's, or white noise. The truth of a contact is the convex hull of the sheet that touches; of a level it is the line of the surface
without noise. For each shape and noise: answers, root mean squares of error over stated, and the mean and the root mean square of how far
the border lies out (the error of the area over the perimeter), mm.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from outline_kinds import ellipse, prism
from scipy.spatial import ConvexHull

from stretch_bt.accuracy.perception.noise import CLEAN, WHITE_03, Noise, observe
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, BodyPress, SheetView, seen_of
from stretch_bt.accuracy.summary import rms
from stretch_bt.errors import NoAnswer
from stretch_bt.perception import contact_outline, deproject, find_contact, highest_of, outline_at, to_membrane
from stretch_bt.perception.outlines.contact_outline import UNSEEN
from stretch_bt.perception.outlines.polyline import area_of, perimeter_of
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings

MM = 1e3
SHAPES = ("sphere", "cylinder", "box", "oval")
NOISES = {
    "none": CLEAN,
    "white 0.3": WHITE_03,
    "bench x8": Noise(white=0.05e-3, correlated=0.3e-3, count=8),
    "hard x8": Noise(white=0.05e-3, correlated=1e-3, count=8),
    "sr305": Noise(white=0.002e-3, correlated=0.025e-3, kernel=2.4, memory=0.0),
}


@dataclass(frozen=True)
class Pressed:
    """What is seen of a press, and the area, m^2, and the perimeter, m, of where the sheet touches."""

    view: SheetView
    area: float
    perimeter: float


def body(shape: str, rng: np.random.Generator) -> Indenter:
    """Draw a body."""
    edge = rng.uniform(0.7e-3, 2e-3)
    if shape == "sphere":
        return Sphere(2 * float(np.exp(rng.uniform(np.log(8e-3), np.log(40e-3)))))
    if shape == "cylinder":
        return Cylinder(rng.uniform(10e-3, 30e-3), edge)
    if shape == "box":
        return Box(rng.uniform(10e-3, 26e-3), rng.uniform(10e-3, 26e-3), rng.uniform(0, 1.57), edge)
    return prism(ellipse(rng.uniform(14e-3, 28e-3), rng.uniform(10e-3, 16e-3), rng.uniform(0, 3)), edge=edge)


def pressed(shape: str, seed: int) -> Pressed:
    """Draw a press."""
    rng = np.random.default_rng([seed, SHAPES.index(shape), 5])
    drawn, depth = body(shape, rng), rng.uniform(2e-3, 12e-3)
    if isinstance(drawn, Sphere):
        depth = min(depth, 0.8 * drawn.diameter)
    stretch = float(rng.choice([0.0, rng.uniform(3e-3, 60e-3)], p=[0.2, 0.8]))
    at, tilt = tuple(rng.uniform(-6e-3, 6e-3, 2)), tuple(np.radians(rng.normal(0, 1.5, 2)))
    effects = ["bending"] if rng.integers(2) else []
    settings = Settings(mesh=0.6e-3, growth=1.4, budget=3000)
    solved = press(drawn, stretch, depth, at=at, tilt=tilt, effects=effects, settings=settings).detail
    assert isinstance(solved, SheetPress)
    fine = solved.shape.points(900, 1000).reshape(-1, 3)
    near = fine[np.hypot(*(fine[:, :2] - at).T) < 0.03]
    hull = ConvexHull(near[solved.touches(near)][:, :2])
    return Pressed(seen_of(BodyPress(drawn, stretch, depth, at), solved), float(hull.volume), float(hull.area))


def level_line(view: SheetView, below: float) -> tuple[float, float]:
    """Return the area, m^2, and the perimeter, m, of the level line of a surface without noise."""
    from contourpy import contour_generator

    surface = to_membrane(*_points(view))
    level = highest_of(surface) - below
    lines: list[npt.NDArray[np.float64]] = contour_generator(z=np.nan_to_num(surface[..., 2], nan=-1.0)).lines(level)  # type: ignore[assignment]
    line = (max(lines, key=len) - [CAMERA.cx, CAMERA.cy]) / [CAMERA.fx, CAMERA.fy] * (PLANE_DISTANCE - level)
    curve = line[:-1, 0] + 1j * line[:-1, 1]
    return area_of(curve), perimeter_of(curve)


def _points(view: SheetView) -> tuple[npt.NDArray[np.floating], float]:
    return deproject(observe(view, CLEAN, 0))[0], PLANE_DISTANCE


def errors(case: Pressed, noise: Noise, seed: int, level: float | None) -> tuple[float, ...]:
    """Return the errors of area, perimeter and circularity over stated, and how far the border lies out, mm."""
    contact = find_contact(observe(case.view, noise, seed))
    if level is None:
        found, area, perimeter = contact_outline(contact), case.area, case.perimeter
    else:
        found = outline_at(contact.surface, level, noise=contact.surface_noise)
        area, perimeter = level_line(case.view, level)
    ratio = found.roundness()
    return (
        (found.area - area) / found.area_sd,
        (found.perimeter - perimeter) / found.perimeter_sd,
        (ratio.circularity - 4 * np.pi * area / perimeter**2) / ratio.circularity_sd,
        MM * (found.area - area) / (0.5 * (found.perimeter + perimeter)),
        MM * found.place_sd,
    )


def rows(shapes: list[str], seeds: range, level: float | None) -> Iterator[str]:
    """Yield a line for each shape and noise, and one for the borders there that curvature does not show."""
    yield "shape     noise             answers  area  perimeter  circularity  out, mm: mean    rms  stated"
    for shape in shapes:
        found: dict[str, list[tuple[float, ...]]] = defaultdict(list)
        for seed in seeds:
            try:
                case = pressed(shape, seed)
            except NoAnswer:
                continue
            for name, noise in NOISES.items():
                try:
                    each = errors(case, noise, 1000 * seed + 1, level)
                    found[name if each[4] < MM * UNSEEN or level is not None else f"{name}, unseen"].append(each)
                except NoAnswer:
                    continue
        for name in [name for noise in NOISES for name in (noise, f"{noise}, unseen") if found[name]]:
            area, perimeter, ratio, out, place = np.array(found[name]).T.tolist()
            yield (
                f"{shape:9s} {name:16s} {len(area):3d} of {len(seeds):3d}  {rms(area):4.2f}  {rms(perimeter):9.2f}"
                f"  {rms(ratio):11.2f}  {np.mean(out):+13.2f}  {rms(out):5.2f}  {np.median(place):6.2f}"
            )


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--shapes", nargs="+", choices=SHAPES, default=list(SHAPES))
    parser.add_argument(
        "--level", type=float, help="mm below the top; without it the border of the contact is measured"
    )
    given = parser.parse_args()
    level = None if given.level is None else given.level / MM
    for line in rows(given.shapes, range(given.first, given.first + given.seeds), level):
        print(line, flush=True)


if __name__ == "__main__":
    main()
