"""Sides and rotation of rectangles on solved sheets, and which shapes are distinguished.

python benchmarks/perception_rectangle.py [FRAMES] [PARTS]

Boxes of 10 x 20 to 20 x 30 mm at any angle, up to 8 mm off centre, at random depths of 5 to 15 mm; the seed of a
frame is its number. PARTS are of "white", "correlated" and "shapes". A miss is a refusal or an error of more than 5 mm. The prior of
the skirt comes from other presses (benchmarks/perception_skirt_rectangle.py).
"""

from __future__ import annotations

import math
import sys
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.noise import CORRELATED, WHITE_05, Noise, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.accuracy.summary import rms
from stretch_bt.errors import NoAnswer
from stretch_bt.perception import find_contact
from stretch_bt.perception.size.measure import measure_contact
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

Array = npt.NDArray[np.float64]

STRETCHES = (0, 10, 20, 30, 40, 50, 60)  # mm
MISS = 5e-3
MM, DEGREES = 1e3, 180.0 / math.pi
BOUNDS = {"white": "asked .6 mm, 1.5 degrees", "correlated": "asked 1.5 mm at depth 10 mm and more, misses 3 %"}


def presses(count: int) -> list[BodyPress]:
    """Return random presses of boxes, the first side the shorter one."""
    rng = np.random.default_rng(12345)
    found = []
    for _ in range(count):
        first, second = float(rng.uniform(10e-3, 20e-3)), float(rng.uniform(20e-3, 30e-3))
        angle, stretch, depth = (
            rng.uniform(-np.pi / 2, np.pi / 2),
            rng.choice(STRETCHES) * 1e-3,
            rng.uniform(5e-3, 15e-3),
        )
        at = rng.uniform(-8e-3, 8e-3, 2)
        found.append(
            BodyPress(Box(first, second, float(angle)), float(stretch), float(depth), (float(at[0]), float(at[1])))
        )
    return found


def row_of(press: BodyPress, noise: Noise, seed: int) -> list[float]:
    """Return depth, stretch, errors of short and long side and rotation, their sd, and CPU time in ms; NaN if refused."""
    assert isinstance(press.indenter, Box)
    frame = observe(seen(press), noise, seed)
    try:
        contact = find_contact(frame)
        start = time.process_time()
        size = measure_contact(contact.surface, contact.labels, stretch=press.stretch, hypothesis="rectangle")
        ms = 1e3 * (time.process_time() - start)
    except NoAnswer:
        return [press.depth, press.stretch, *[math.nan] * 7]
    assert size.sides is not None
    assert size.sides_sd is not None
    assert size.rotation is not None
    assert size.rotation_sd is not None
    turned = (size.rotation - press.indenter.angle + math.pi / 4) % (
        math.pi / 2
    ) - math.pi / 4  # which side is short may flip
    errors = [size.sides[0] - press.indenter.first, size.sides[1] - press.indenter.second, turned]
    return [press.depth, press.stretch, *errors, *size.sides_sd, size.rotation_sd, ms]


def accuracy(name: str, noise: Noise, frames: int) -> Iterator[str]:
    """Yield a line for each depth and stretch."""
    yield f"{name}: {BOUNDS[name]}"
    yield "                    n  misses %   short mm (bias)     long mm (bias)  rotation deg   error/sd short long rotation   ms"
    least = 10e-3 if name == "correlated" else 0.0
    deep = [press for press in presses(frames) if press.depth >= least]
    rows = np.array([row_of(deep[seed % len(deep)], noise, seed) for seed in range(frames)])
    depth, stretch = rows[:, 0] * MM, rows[:, 1] * MM
    for low, high in ((5, 7.5), (7.5, 10), (10, 12.5), (12.5, 15)):
        yield from line(f"depth {low:4} to {high:4}", rows[(depth >= low) & (depth < high)])
    for x in STRETCHES:
        yield from line(f"stretch {x:2d}", rows[np.rint(stretch) == x])
    yield from line("all", rows)


def line(name: str, rows: Array) -> Iterator[str]:
    if not len(rows):
        return
    missed = ~(np.abs(rows[:, 2:4]) < MISS).all(axis=1)
    short, long, turn, *sd = rows[~missed].T[2:8]
    text = f"{name:18s} {len(rows):4d}  {100 * missed.mean():8.1f}"
    for errors in (short, long):
        text += f"   {rms(errors) * MM:7.2f} ({errors.mean() * MM:+.2f})"
    text += f"   {rms(turn) * DEGREES:12.2f}"
    text += "        " + "  ".join(f"{rms(e / s):5.2f}" for e, s in zip((short, long, turn), sd, strict=True))
    yield f"{text}   {np.median(rows[~missed, 8]):5.0f}"


def shapes(frames: int) -> Iterator[str]:
    """Yield the table of pressed shapes and the shapes found."""
    yield "shapes distinguished: rows are the pressed bodies, columns the shapes found"
    rng = np.random.default_rng(54321)
    names = ("circle", "ellipse", "rectangle", "free_form", "refused")
    for label, noise, least in (("white", WHITE_05, 5e-3), ("correlated", CORRELATED, 10e-3)):
        yield f"{label:32s}" + "  ".join(f"{n:>9s}" for n in names) + "      ms"
        for kind in ("cylinder 10 to 30 mm", "box 10 x 20 to 20 x 30 mm", "box 15 x 15 mm", "box 20 x 20 mm"):
            called, times = Counter[str](), []
            for seed in range(frames):
                name, ms = called_of(random_press(kind, rng, least, seed), noise, seed)
                called[name] += 1
                times.append(ms)
            yield f"{kind:32s}" + "  ".join(f"{called[n]:9d}" for n in names) + f"  {np.median(times):6.0f}"


def random_press(kind: str, rng: np.random.Generator, least: float, number: int) -> BodyPress:
    stretch, depth = float(rng.choice(STRETCHES)) * 1e-3, float(rng.uniform(least, 15e-3))
    at, angle = rng.uniform(-8e-3, 8e-3, 2), float(rng.uniform(-np.pi / 2, np.pi / 2))
    diameter = float(rng.uniform(10e-3, 30e-3))
    if kind.startswith("cylinder"):
        return BodyPress(Cylinder(diameter), stretch, depth, (float(at[0]), float(at[1])))
    if kind == "box 15 x 15 mm":
        return BodyPress(Box(15e-3, 15e-3, angle), stretch, depth, (float(at[0]), float(at[1])))
    if kind == "box 20 x 20 mm":
        return BodyPress(Box(20e-3, 20e-3, angle), stretch, depth, (float(at[0]), float(at[1])))
    return [p for p in presses(200) if p.depth >= least][number]


def called_of(press: BodyPress, noise: Noise, seed: int) -> tuple[str, float]:
    """Return the shape that a frame is said to show, and the CPU time in ms."""
    frame = observe(seen(press), noise, seed)
    try:
        contact = find_contact(frame)
        start = time.process_time()
        size = measure_contact(contact.surface, contact.labels, stretch=press.stretch)
    except NoAnswer:
        return "refused", math.nan
    return size.shape, 1e3 * (time.process_time() - start)


def main() -> None:
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    parts = sys.argv[2:] or ["white", "correlated", "shapes"]
    for name, noise in (("white", WHITE_05), ("correlated", CORRELATED)):
        if name in parts:
            for text in accuracy(name, noise, frames):
                print(text, flush=True)
    if "shapes" in parts:
        for text in shapes(frames):
            print(text, flush=True)


if __name__ == "__main__":
    main()
