"""Heights of flat tops that lean: error, stated deviation and answers, by shape, lean and noise.

    python benchmarks/leaning_tops.py [--draws 48] [--first 0] [--noise NAME ...] [--shape NAME ...] [--sizes] [--each]

The membrane and the noise come from `benchmarks.height_noise`. Cylinders and blocks 10 to 40 mm across lean by 0 to 8 degrees towards
anywhere, their middle 3 to 12 mm deep, such that the membrane lies on all of the face, which else shows no middle. The height of the face
at its middle is asked for. `--first 24` draws surfaces that no constant was set over.
`--sizes` measures the widths of the faces in place of their heights.
"""

from __future__ import annotations

import argparse
import math
from functools import cache

import numpy as np
import numpy.typing as npt
from height_noise import (
    FILLET,
    LONG,
    NOISES,
    PITCH,
    WIDE,
    Noise,
    Surface,
    height,
    relaxed,
    rounded,
    seen,
    viewed,
)

from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.perception import find_contact, measure_contact
from stretch_bt.threads import one_thread

Array = npt.NDArray[np.float64]

POOL = 24  # surfaces of each shape and band of leans
LEANS = ((0.0, 0.0), (0.5, 2.0), (2.0, 4.0), (4.0, 6.0), (6.0, 8.0))  # degrees
SIZES = 10e-3, 40e-3  # m, across
DEPTHS = 3e-3, 12e-3  # m, of the middle
ALL = 0.99  # of the face, that the membrane lies on
TOUCHES = 1e-6  # m, within which it does
ASIDE = 4e-3  # m, of the face's middle from the membrane's middle, at most, along each axis
CASES = ("white 0.3", "bench", "shared 0.3, 3 px", "shared 0.3, 5 px")


def main() -> None:
    """Print a line for each noise, shape and band of leans."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=48)
    parser.add_argument("--first", type=int, default=0, help="number of the first surface of each row")
    parser.add_argument("--noise", nargs="*", default=list(CASES))
    parser.add_argument("--shape", nargs="*", default=["cylinder", "box"])
    parser.add_argument("--sizes", action="store_true", help="widths along i and j in place of heights")
    parser.add_argument("--each", action="store_true")
    given = parser.parse_args()
    print(
        "noise                     shape     lean      error/stated  error, mm: bias  rms   most  stated, median  answers"
    )
    with one_thread():
        for noise in given.noise:
            for shape in given.shape:
                for band in range(len(LEANS)):
                    print(
                        f"{noise:25s} {shape:9s} {_text(band):9s} {_row(shape, band, NOISES[noise], given)}", flush=True
                    )


def _text(band: int) -> str:
    return "{:g} to {:g}".format(*LEANS[band])


def _row(shape: str, band: int, noise: Noise, given: argparse.Namespace) -> str:
    off, stated, answers = list[float](), list[float](), 0
    for number in range(given.draws):
        surface, text, wide = _leaning(shape, band, given.first + number % POOL)
        try:
            found = _found(
                seen(surface, noise, np.random.default_rng((number, 7))), surface.top, wide, sizes=given.sizes
            )
        except NoAnswer as error:
            text += f" refused: {error.reason}"
        else:
            off += [far for far, _ in found]
            stated += [sd for _, sd in found]
            answers += 1
            text += "".join(f" {1e3 * far:+.3f} of {1e3 * sd:.3f}" for far, sd in found)
        if given.each:
            print("   ", number, text)
    if not off:
        return "no answer"
    e, s = 1e3 * np.array(off), 1e3 * np.array(stated)
    return (
        f"{np.sqrt(np.mean((e / s) ** 2)):9.2f} {e.mean():16.3f} {np.sqrt(np.mean(e**2)):9.3f} {np.abs(e).max():6.2f}"
        f" {np.median(s):10.3f} {100 * answers / given.draws:12.0f} %"
    )


def _found(frame: DepthFrame, top: float, wide: Array, *, sizes: bool) -> list[tuple[float, float]]:
    """Return how far off a height, or the widths along i and j, are, and what they state, m."""
    if not sizes:
        found = height(frame)
        return [(found.value - top, found.sd)]
    contact = find_contact(frame)
    size = measure_contact(contact.surface, contact.labels)
    return [(size.diameter_i - wide[0], size.diameter_i_sd), (size.diameter_j - wide[1], size.diameter_j_sd)]


def leaning(shape: str, band: int, number: int) -> tuple[Surface, str]:
    """Return one surface of a shape that leans by a band of LEANS, and its description; the same numbers give the same."""
    return _leaning(shape, band, number)[:2]


@cache
def _leaning(shape: str, band: int, number: int) -> tuple[Surface, str, Array]:
    """Do as `leaning`, with the widths of the face along i and j, m."""
    rng = np.random.default_rng((number, band, *shape.encode()))
    while True:
        found = _drawn(shape, band, rng)
        if found is not None:
            return found


def _drawn(shape: str, band: int, rng: np.random.Generator) -> tuple[Surface, str, Array] | None:
    """Return a random surface, its description and the widths of its face; None where the membrane leaves the face."""
    x, y = np.arange(-WIDE, WIDE + PITCH / 2, PITCH), np.arange(-LONG, LONG + PITCH / 2, PITCH)
    lean, towards = math.radians(rng.uniform(*LEANS[band])), rng.uniform(0.0, 2.0 * math.pi)
    half, at, top = rng.uniform(*SIZES, 2) / 2.0, rng.uniform(-ASIDE, ASIDE, 2), float(rng.uniform(*DEPTHS))
    u, v = x[None, :] - at[0], y[:, None] - at[1]
    face = _face(shape, u, v, half)
    body = top + math.tan(lean) * (math.cos(towards) * u + math.sin(towards) * v) + face
    z = relaxed(body, float(rng.uniform(2.0, 8.0)))
    if np.mean(z[face == 0.0] - body[face == 0.0] < TOUCHES) < ALL:
        return None
    size = f"{2e3 * half[0]:.0f}" if shape == "cylinder" else "{:.0f} x {:.0f}".format(*2e3 * half)
    text = f"{size} mm, {1e3 * top:.1f} deep, {math.degrees(lean):.1f} deg towards {math.degrees(towards):.0f}"
    return Surface(viewed(x, y, z), top), text, 2.0 * (half if shape == "box" else half[[0, 0]])


def _face(shape: str, u: Array, v: Array, half: Array) -> Array:
    """Return the heights of a flat face beside its middle, half so wide and long, m."""
    if shape == "cylinder":
        return rounded(np.hypot(u, v) - (half[0] - FILLET))
    past = [np.maximum(np.abs(w) - (a - FILLET), 0.0) for w, a in zip((u, v), half, strict=True)]
    return rounded(np.hypot(*past))


if __name__ == "__main__":
    main()
