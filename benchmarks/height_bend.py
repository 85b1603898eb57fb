"""How far the vertex of a quadratic over a wide disc lies below a top: the law of `stretch_bt/perception/wide_top.py`, and what it leaves.

    python benchmarks/height_bend.py [--draws 24] [--first 0] [--noise NAME ...]

The discs lie about the contact that noise leaves, as wide as it or wider, in the frame without noise. A disc is as pointed as its tip over
its fall says. The law is fitted to the surfaces of `benchmarks.height_noise`, each shape with the same weight; the last two columns say what
the law in the code leaves of the same draws, so that a `--first` beyond the draws that it was made with tries it elsewhere.
"""

from __future__ import annotations

import argparse

import numpy as np
import numpy.typing as npt
from height_noise import NOISES, Noise, Surface, seen, surface_of

from stretch_bt.errors import NoAnswer
from stretch_bt.perception import find_contact, wide_top
from stretch_bt.perception.top import Points, disc_of
from stretch_bt.perception.tops import contacts, noise_around, surroundings

Array = npt.NDArray[np.float64]

SHAPES = (
    *("sphere", "cap", "cylinder", "box", "sheet sphere", "sheet cylinder", "sheet box"),
    *(f"analytic {kind}" for kind in ("sphere", "disc", "tip", "light", "cone")),
)
QUIET = Noise(1e-5, unit=1e-5)
LEAST_TOP = 1e-3  # m


def main() -> None:
    """Print the law by the radius of the disc, and what is left of the height."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=24)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--noise", nargs="*", default=["shared 0.3, 2 px", "bench"])
    given = parser.parse_args()
    rows, weights = list[Array](), list[float]()
    for noise in given.noise:
        for shape in SHAPES:
            of_shape = [
                row
                for number in range(given.first, given.first + given.draws)
                if (row := _row(surface_of(shape, number), NOISES[noise], number)) is not None
            ]
            rows += of_shape
            weights += [1.0 / max(len(of_shape), 1)] * len(of_shape)
    _print(np.array(rows), np.array(weights))


def _row(surface: Surface, noise: Noise, number: int) -> Array | None:
    """Return for each disc how pointed it is and how far its vertex lies below the top, over the height (5, 2); None without a contact."""
    if surface.top < LEAST_TOP:
        return None
    random = np.random.default_rng((number, 7))
    try:
        noisy, quiet = find_contact(seen(surface, noise, random)), find_contact(seen(surface, QUIET, random))
    except NoAnswer:
        return None
    points = quiet.surface
    valid = np.isfinite(points[..., 2])
    places = contacts(noisy.labels)[0]
    places = places[valid.reshape(-1)[places]]
    spectrum = noise_around(points, valid, places)
    if spectrum is None or places.size < wide_top.LEAST_POINTS:
        return None
    contact = Points(np.ascontiguousarray(points.reshape(-1, 3)[places].T), places, valid.shape[1], spectrum)
    around = surroundings(points, valid, contact, spectrum)
    middle, _, radius = disc_of(contact.cloud)
    return np.array([_of_disc(around, middle, share * radius, surface.top) for share in wide_top.RADII])


def _of_disc(around: Points, middle: Array, radius: float, top: float) -> tuple[float, float]:
    disc = wide_top.disc_top(around, middle, radius)
    if disc is None:
        return np.nan, np.nan
    most = wide_top.MOST_POINTED
    pointed = float(np.clip(disc.tip(0.5 * radius).value / disc.fall, -most, most))
    return pointed, 1.0 - disc.estimate(0.5 * radius).value / top


def _print(rows: Array, weights: Array) -> None:
    print("disc  pointed: mean    sd   law: 1    pointed  square   left, rms   by the code: mean    rms")
    for k, share in enumerate(wide_top.RADII):
        pointed, below = rows[:, k].T
        fits = np.isfinite(pointed)
        pointed, below, w = pointed[fits], below[fits], weights[fits] / weights[fits].sum()
        mean = float(w @ pointed)
        design = np.stack([np.ones_like(pointed), pointed, pointed**2], axis=1)
        law = np.linalg.lstsq(design * np.sqrt(w)[:, None], below * np.sqrt(w), rcond=None)[0]
        left = below - design @ law
        by_code = below - design @ np.array([row[k] for row in wide_top.BELOW])
        print(
            f"{share:4.1f} {mean:14.2f} {np.sqrt(w @ (pointed - mean) ** 2):6.2f} {law[0]:9.3f} {law[1]:8.2f} {law[2]:8.2f}"
            f" {np.sqrt(w @ left**2):10.3f} {w @ by_code:18.3f} {np.sqrt(w @ by_code**2):7.3f}"
        )


if __name__ == "__main__":
    main()
