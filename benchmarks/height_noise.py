"""Heights of tops under noise that pixels share: error, stated deviation and answers, by shape and by noise.

    python -m benchmarks.height_noise [--draws 200] [--noise NAME ...] [--shape NAME ...] [--pixel 0.42] [--jobs 1]

The membrane is a linear one, T_i z_xx + T_j z_yy = 0 wherever it does not lie on the body, relaxed on a grid of 0.5 mm, so that it leaves
caps, cylinders and boxes tangentially; its tensions, the bodies and their places are drawn. It shares nothing with the solver of the sheet.
Beside it stand the sheet of that solver, and surfaces in closed form that end in a kink, as no membrane does. Noise is white, or white noise
after a Gaussian of some pixels, or both, with the counts of a camera; whole rows or columns may also share some. Of two bodies side by
side, the higher top is asked for.
`free` is a membrane that touches nothing: how many of its frames have a height. `--pixel` is the width of a pixel on the membrane, mm; the
presses of the sheet are seen by pixels of 0.42 mm alone.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from itertools import repeat
from multiprocessing import get_context
from time import process_time

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception import analytic
from stretch_bt.accuracy.perception.view import BodyPress
from stretch_bt.accuracy.perception.view import seen as view_of
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import find_contact, track_height
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.threads import one_thread
from stretch_bt.units import Estimate

Array = npt.NDArray[np.float64]

CAMERA, DISTANCE = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333), 0.2
PITCH, WIDE, LONG = 0.5e-3, 0.045, 0.058  # m; of the grid, half the width, half the length
FILLET = 1e-3  # m
TIPS = (0.5e-3, 6e-3)  # m, radii of the balls of tips
POOL = 48  # surfaces of each shape
LEAST_DEPTH = 1e-3  # m; below it a refusal does not count


@dataclass(frozen=True)
class Surface:
    """The depth (h, w), m, that a camera without noise sees, and the height of the highest top, m."""

    depth: Array
    top: float
    camera: Intrinsics = CAMERA


@dataclass(frozen=True)
class Noise:
    """Standard deviations, m: white, (m, pixels) of parts that are white noise after a Gaussian of so many pixels, of rows and of columns."""

    white: float
    shared: tuple[tuple[float, float], ...] = ()
    unit: float = 0.125e-3
    frames: int = 1
    rows: float = 0.0
    columns: float = 0.0


NOISES = {
    "white 0.05": Noise(0.05e-3),
    "white 0.3": Noise(0.3e-3),
    "white 1": Noise(1e-3),
    "counts only": Noise(0.0),
    "shared 0.3, 1 px": Noise(0.0, ((0.3e-3, 1.0),)),
    "shared 0.3, 2 px": Noise(0.0, ((0.3e-3, 2.0),)),
    "shared 0.3, 3 px": Noise(0.0, ((0.3e-3, 3.0),)),
    "shared 0.6, 3 px": Noise(0.0, ((0.6e-3, 3.0),)),
    "shared 0.3, 5 px": Noise(0.0, ((0.3e-3, 5.0),)),
    "shared 0.3, 8 px": Noise(0.0, ((0.3e-3, 8.0),)),
    "bench": Noise(0.05e-3, ((0.3e-3, 3.0),)),
    "bench, 8 frames": Noise(0.018e-3, ((0.19e-3, 3.0),), 0.125e-3 / 16),
    "SR305": Noise(0.02e-3, ((0.05e-3, 1.1),)),
    "white 0.3 and 0.15, 8 px": Noise(0.3e-3, ((0.15e-3, 8.0),)),
    "white 0.6, counts of 1": Noise(0.6e-3, unit=1e-3),
    "shared 0.4, 3 px, of 1": Noise(0.05e-3, ((0.4e-3, 3.0),), 1e-3),
    "white 0.1, columns 0.2": Noise(0.1e-3, columns=0.2e-3),
    "white 0.1, rows 0.3": Noise(0.1e-3, rows=0.3e-3),
    "white 0.1, both 0.2": Noise(0.1e-3, rows=0.2e-3, columns=0.2e-3),
    "bench, columns 0.2": Noise(0.05e-3, ((0.3e-3, 3.0),), columns=0.2e-3),
}


def main() -> None:
    """Print a line for each noise and shape."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--noise", nargs="*", default=list(NOISES))
    parser.add_argument("--shape", nargs="*", default=[*SHAPES, *OTHERS])
    parser.add_argument(
        "--pixel", type=float, default=DISTANCE / CAMERA.fx * 1e3, help="width of a pixel on the membrane, mm"
    )
    parser.add_argument("--jobs", type=int, default=1, help="lines that are worked out side by side")
    given = parser.parse_args()
    print(
        "noise                     shape              error/stated, most  error, mm: bias  rms   most  stated, median  answers at 1 mm"
    )
    asked = [(noise, shape) for noise in given.noise for shape in given.shape]
    with ProcessPoolExecutor(given.jobs, get_context("spawn")) as pool:
        for (noise, shape), row in zip(
            asked, pool.map(_line, asked, repeat(given.draws), repeat(given.pixel)), strict=True
        ):
            print(f"{noise:25s} {shape:16s} {row}", flush=True)


def _line(asked: tuple[str, str], draws: int, pixel: float) -> str:
    with one_thread():
        return _row(asked[1], NOISES[asked[0]], draws, camera_of(1e-3 * pixel))


def camera_of(pixel: float) -> Intrinsics:
    """Return the camera that sees the same with pixels so wide on the membrane, m."""
    wider = pixel * CAMERA.fx / DISTANCE
    f, cx, cy = (value / wider for value in (CAMERA.fx, CAMERA.cx, CAMERA.cy))
    return Intrinsics(f, f, cx, cy, round(CAMERA.width / wider), round(CAMERA.height / wider))


def _row(shape: str, noise: Noise, draws: int, camera: Intrinsics) -> str:
    errors, stated, spent, refused, asked = [], [], [], Counter[str](), 0
    for number in range(draws):
        surface = surface_of(shape, number % POOL, camera)
        frame = seen(surface, noise, np.random.default_rng((number, 7)))
        begun = process_time()
        deep = surface.top >= LEAST_DEPTH
        asked += deep
        try:
            found = height(frame)
        except NoAnswer as error:
            refused[str(error.reason)[:40]] += deep
            continue
        spent.append(process_time() - begun)
        errors.append(found.value - surface.top)
        stated.append(found.sd)
    if not errors:
        return f"no answer {dict(refused)}"
    e, s = 1e3 * np.array(errors), 1e3 * np.array(stated)
    answers = 1.0 - sum(refused.values()) / asked if asked else len(errors) / draws
    return (
        f"{np.sqrt(np.mean((e / s) ** 2)):14.2f} {np.abs(e / s).max():5.1f} {e.mean():16.3f} {np.sqrt(np.mean(e**2)):9.3f} {np.abs(e).max():6.2f}"
        f" {np.median(s):10.3f}"
        f" {100 * answers:12.0f} %  {1e3 * np.median(spent):.1f} ms {dict(refused) if refused else ''}"
    )


def height(frame: DepthFrame) -> Estimate:
    """Return the height of the top in a frame."""
    contact = find_contact(frame)
    return track_height(contact.surface, np.isfinite(contact.surface[..., 2]), contact.labels)


def seen(surface: Surface, noise: Noise, rng: np.random.Generator) -> DepthFrame:
    """Return the frame of a camera with such noise."""
    depth = surface.depth + noise.white * rng.standard_normal(surface.depth.shape)
    for sd, length in noise.shared:
        depth += sd * alike(depth.shape, length, rng)
    if noise.rows or noise.columns:
        high, wide = depth.shape
        depth += noise.rows * rng.standard_normal((high, 1)) + noise.columns * rng.standard_normal((1, wide))
    kept = (surface.depth > 0.0) & (rng.random(depth.shape) > 0.01)
    raw = np.where(kept, np.clip(np.rint(depth / noise.unit), 0, 65535), 0).astype(np.uint16)
    return DepthFrame(raw, noise.unit, surface.camera, 0.0, 0, DISTANCE, hand_height=0.0, stretch=0.016)


def alike(shape: tuple[int, ...], length: float, rng: np.random.Generator) -> Array:
    """Return noise (h, w) of standard deviation 1 that is white noise after a Gaussian of `length` pixels."""
    from scipy.ndimage import gaussian_filter

    margin = int(4 * length) + 1
    wide = rng.standard_normal((shape[0] + 2 * margin, shape[1] + 2 * margin))
    blurred = gaussian_filter(wide, length)[margin:-margin, margin:-margin]
    return np.asarray(2.0 * np.sqrt(np.pi) * length * blurred / _gain(length))


@lru_cache(maxsize=16)
def _gain(length: float) -> float:
    """Return the sum of squares of the discrete kernel of a short length over the sum by the formula."""
    from scipy.ndimage import gaussian_filter1d

    line = np.zeros(int(10 * length) * 2 + 3)
    line[len(line) // 2] = 1.0
    return float((gaussian_filter1d(line, length) ** 2).sum() * 2.0 * np.sqrt(np.pi) * length)


# bodies that press into the membrane: heights (n, m), m, of the upper side, with the top at 0, over places beside the middle


def _ball(x: Array, y: Array, radius: float) -> Array:
    inside = radius**2 - x * x - y * y
    return np.where(inside > 0.0, np.sqrt(np.maximum(inside, 0.0)) - radius, -1.0)


def rounded(past: Array) -> Array:
    """Return the height over a place so far past where the fillet of a flat face begins, m."""
    on = np.maximum(past, 0.0)
    return np.where(on < FILLET, np.sqrt(np.maximum(FILLET**2 - on * on, 0.0)) - FILLET, -1.0)


def _disc(x: Array, y: Array, radius: float) -> Array:
    return rounded(np.hypot(x, y) - (radius - FILLET))


def _block(x: Array, y: Array, half: tuple[float, float]) -> Array:
    u, v = (np.maximum(np.abs(w) - (a - FILLET), 0.0) for w, a in zip((x, y), half, strict=True))
    return rounded(np.hypot(u, v))


Body = Callable[[Array, Array, np.random.Generator], tuple[Array, float]]


def _place(rng: np.random.Generator) -> tuple[float, float]:
    return float(rng.uniform(-8e-3, 8e-3)), float(rng.uniform(-10e-3, 10e-3))


def _one(kind: str) -> Body:
    def body(x: Array, y: Array, rng: np.random.Generator) -> tuple[Array, float]:
        at, top = _place(rng), float(rng.uniform(1e-3, 12e-3))
        u, v = x - at[0], y - at[1]
        if kind == "sphere":
            return top + _ball(u, v, rng.uniform(5e-3, 20e-3)), top
        if kind == "cap":
            return top + _ball(u, v, rng.uniform(25e-3, 60e-3)), top
        if kind == "cylinder":
            return top + _disc(u, v, rng.uniform(5e-3, 15e-3)), top
        return top + _block(u, v, tuple(rng.uniform(5e-3, 12e-3, 2))), top

    return body


def _two(x: Array, y: Array, rng: np.random.Generator) -> tuple[Array, float]:
    """Two bodies 22 to 34 mm apart along the stretch, as high or one up to 1.5 mm lower."""
    apart, top = rng.uniform(11e-3, 17e-3), float(rng.uniform(4e-3, 12e-3))
    low = top - float(rng.choice([0.0, rng.uniform(0.0, 1.5e-3)]))
    radius = rng.uniform(5e-3, 9e-3)
    shape = partial(_ball if rng.random() < 0.5 else _disc, radius=radius)
    return np.maximum(top + shape(x, y - apart), low + shape(x, y + apart)), top


SHAPES: dict[str, Body] = {**{kind: _one(kind) for kind in ("sphere", "cap", "cylinder", "box")}, "two": _two}


def _of_sheet(kind: str, rng: np.random.Generator, camera: Intrinsics) -> Surface:
    """Return a press of the finite-strain sheet, stretched by 5 to 60 mm."""
    body = {"sphere": Sphere, "cylinder": Cylinder, "box": Cube}[kind](float(rng.uniform(12e-3, 36e-3)))
    if camera != CAMERA:
        raise SystemExit(
            "presses of the sheet are seen by pixels of 0.42 mm alone; leave out --pixel, or name other shapes by --shape"
        )
    view = view_of(BodyPress(body, float(rng.uniform(5e-3, 60e-3)), float(rng.uniform(2e-3, 12e-3)), _place(rng)))
    heights = DISTANCE - view.depth[view.touching].astype(np.float64)
    return Surface(view.depth.astype(np.float64), float(heights.max() if kind == "sphere" else np.median(heights)))


def _in_closed_form(kind: str, rng: np.random.Generator, camera: Intrinsics) -> Surface:
    """Return a body of revolution in a skirt that falls as a logarithm and ends in the flat plane with a kink."""
    if kind == "tip":
        profile = _tip(float(np.exp(rng.uniform(*np.log(TIPS)))), float(rng.uniform(3.5e-3, 8e-3)))
    elif kind == "light":
        radius = float(rng.uniform(4e-3, 16e-3))
        profile = analytic.sphere_press(radius, float(np.arcsin(rng.uniform(1.4e-3, 2.8e-3) / radius)))
    elif kind == "cone":
        profile = analytic.cone_press(float(np.exp(rng.uniform(*np.log((0.18, 1.0))))), float(rng.uniform(3e-3, 9e-3)))
    elif kind == "sphere":
        profile = analytic.sphere_press(float(rng.uniform(8e-3, 30e-3)), float(rng.uniform(0.2, 0.65)))
    else:
        profile = analytic.disc_press(float(rng.uniform(5e-3, 15e-3)), float(rng.uniform(1e-3, 12e-3)))
    depth = analytic.render(profile, camera, *_place(rng))
    return Surface(depth, DISTANCE - float(depth.min()), camera)


def _tip(radius: float, depth: float) -> Callable[[Array], Array]:
    """Return the height over distance from the axis, m, of a membrane that a ball of a radius presses so deep."""
    from scipy.optimize import brentq

    def past(angle: float) -> float:
        return float(analytic.sphere_press(radius, angle)(np.zeros(1))[0]) - depth

    return analytic.sphere_press(radius, float(brentq(past, 0.05, 1.4)))


def _free(kind: str, rng: np.random.Generator, camera: Intrinsics) -> Surface:
    return Surface(np.full((camera.height, camera.width), DISTANCE), 0.0, camera)


OTHERS: dict[str, Callable[[str, np.random.Generator, Intrinsics], Surface]] = {
    **dict.fromkeys(("sheet sphere", "sheet cylinder", "sheet box"), _of_sheet),
    **dict.fromkeys(tuple(f"analytic {kind}" for kind in ("sphere", "disc", "tip", "light", "cone")), _in_closed_form),
    "free": _free,
}


@cache
def surface_of(shape: str, number: int, camera: Intrinsics = CAMERA) -> Surface:
    """Return one surface of a shape; the same number gives the same."""
    rng = np.random.default_rng((number, *shape.encode()))
    if shape in OTHERS:
        return OTHERS[shape](shape.rsplit(maxsplit=1)[-1], rng, camera)
    x, y = np.arange(-WIDE, WIDE + PITCH / 2, PITCH), np.arange(-LONG, LONG + PITCH / 2, PITCH)
    body, top = SHAPES[shape](x[None, :], y[:, None], rng)
    return Surface(viewed(x, y, relaxed(body, float(rng.uniform(2.0, 8.0))), camera), top, camera)


def relaxed(body: Array, ratio: float) -> Array:
    """Return the membrane (n, m), m, clamped at the first and the last row, free at its sides, over a body; successive over-relaxation."""
    rows, columns = body.shape
    wide = np.zeros((rows, columns + 2))  # with the columns that mirror those beside the free sides
    z = wide[:, 1:-1]
    z[1:-1] = np.maximum(body, 0.0)[1:-1]
    omega = 2.0 / (1.0 + np.pi / rows)
    for _ in range(6 * rows):
        before = z.copy()
        for colour in (0, 1):
            wide[:, 0], wide[:, -1] = z[:, 1], z[:, -2]
            for row in (1, 2):
                _move(z, wide, body, (row, (row + colour) % 2), ratio, omega)
        if np.abs(z - before).max() < 1e-8:
            break
    return z


def _move(z: Array, wide: Array, body: Array, first: tuple[int, int], ratio: float, omega: float) -> None:
    """Move every second place of every second row, from a first one on; their neighbours stay."""
    row, column = first
    end = len(z) - 1
    here = (slice(row, end, 2), slice(column, None, 2))
    across = wide[row:end:2, column:-2:2] + wide[row:end:2, column + 2 :: 2]
    along = z[row - 1 : end - 1 : 2, column::2] + z[row + 1 : end + 1 : 2, column::2]
    mean = (across + ratio * along) / (2.0 + 2.0 * ratio)
    z[here] = np.maximum(z[here] + omega * (mean - z[here]), body[here])


def viewed(x: Array, y: Array, z: Array, camera: Intrinsics = CAMERA) -> Array:
    """Return the depth (h, w), m, along the axis of the camera, of heights (n, m) over places y, x; 0 beside them."""
    from scipy.ndimage import map_coordinates, spline_filter

    spline = spline_filter(z, mode="mirror")
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    across, along = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    height = np.zeros(u.shape)
    for _ in range(12):
        deep = DISTANCE - height
        places = [(along * deep - y[0]) / PITCH, (across * deep - x[0]) / PITCH]
        height = 0.5 * height + 0.5 * map_coordinates(spline, places, prefilter=False, mode="mirror")
    deep = DISTANCE - height
    return np.where((np.abs(across * deep) < WIDE) & (np.abs(along * deep) < LONG), deep, 0.0)


if __name__ == "__main__":
    main()
