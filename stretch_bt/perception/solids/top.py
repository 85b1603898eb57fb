"""The top of the surface felt: where it is, and whether it is flat, a crest or round."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.views import SolidView

__all__ = ["Height", "Top", "height_map", "peaks_of", "top_of"]

Array = npt.NDArray[np.float64]

CELL = 1e-3  # m
NEAR_TOP = 0.45e-3  # m below the top that counts as top
LEVEL = 0.8e-3  # m
PATCH = 6e-3  # m round the middle over which it is judged
FEWEST = 25  # cells of a patch
LARGE = 0.3  # share of the top's area from which a part as high is another object's
FLOOR = 0.05e-3  # m, difference of the top of a shape under a membrane from a simple surface
ALIKE = 6.0  # cells that err as one
SCALE, APART = 2.8, 6  # cells: Gaussian that smooths heights to find humps, and how far these are apart
SMEARED = 1.5  # cells: Gaussian that smooths the places felt
CURVED = 58.0  # 1/m: least sum of the curvatures of a hump at that scale


@dataclass(frozen=True, slots=True)
class Height:
    """Least height (h, w), m, of the membrane over a grid of the world, NaN where none was; `corner` (2,), m, of cell (0, 0)."""

    z: Array
    corner: Array

    def place(self, cells: npt.NDArray[Any]) -> Array:
        """Return world places (n, 2), m, of cells (n, 2) given as (row along x, column along y)."""
        return np.asarray(self.corner + (np.asarray(cells, float) + 0.5) * CELL)


@dataclass(frozen=True, slots=True)
class Top:
    """Middle (2,), m, and height, m, of the top, `along` (2,) the direction that it is longest in, and the half lengths of it, m.

    `curvatures` (2,), 1/m, are across and along it, positive where the top is convex. `evidence` is for "flat",
    "crest" and "round", nats, 0 for the best. `another` (2,), m, is where
    there is a second top as high and about as large, apart from it.
    """

    middle: Array
    height: float
    along: Array
    half: tuple[float, float]
    curvatures: tuple[float, float]
    evidence: dict[str, float]
    another: Array | None


def height_map(views: list[SolidView]) -> Height:
    """Return the lowest membrane over each place: no object stands above any."""
    every = np.concatenate([view.points[:, :2] for view in views])
    corner = np.floor(every.min(axis=0) / CELL) * CELL
    shape = tuple((np.floor((every.max(axis=0) - corner) / CELL).astype(int) + 1).tolist())
    lowest = np.full(shape, np.inf)
    for view in views:
        cells = np.floor((view.points[:, :2] - corner) / CELL).astype(int)
        flat = np.ravel_multi_index((cells[:, 0], cells[:, 1]), shape)
        count = np.bincount(flat, minlength=lowest.size)
        total = np.bincount(flat, view.points[:, 2], lowest.size)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(count > 0, total / count, np.inf).reshape(shape)
        lowest = np.minimum(lowest, mean)
    return Height(np.where(np.isfinite(lowest), lowest, np.nan), corner)


def peaks_of(grid: Height, views: list[SolidView], low: float) -> list[Array]:
    """Return the places (2,), m, of humps that were felt above a height, m, the highest first; `grid` is the height map of the views.

    A small dome beside a large one makes no summit under a membrane; that the surface is most curved there shows it. Free
    membrane has no mean curvature, or one to the other side, but for where it hangs from a clamp: nothing was felt there.
    """
    from scipy.ndimage import gaussian_filter, gaussian_laplace, maximum_filter

    known, touched = np.isfinite(grid.z), np.zeros(grid.z.shape)
    for view in views:
        touched[tuple(np.floor((view.points[view.touching, :2] - grid.corner) / CELL).astype(int).T)] = 1.0
    z = np.where(known, grid.z, np.median(grid.z[known]))
    whole = (gaussian_filter(known.astype(float), SCALE) > 0.97) & (gaussian_filter(touched, SMEARED) > 0.5)
    curved = np.where(whole, -gaussian_laplace(z, SCALE) / CELL**2, 0.0)
    tops = np.argwhere((curved == maximum_filter(curved, size=2 * APART + 1)) & (curved > CURVED) & (z > low))
    humps = gaussian_filter(z, 1.0)[tuple(tops.T)]
    return [grid.place(cell) for cell in tops[np.argsort(-humps)]]


def top_of(heights: Height) -> Top:
    """Return the highest part of a height map, and its form.

    Raises
    ------
    IllConditioned
        Too little of it is seen.
    """
    from scipy.ndimage import gaussian_filter, label

    known = np.isfinite(heights.z)
    if known.sum() < FEWEST:
        raise IllConditioned(
            "the surface is too small to show its top; press deeper, or nearer to the middle of the object"
        )
    smooth = gaussian_filter(np.where(known, heights.z, np.nanmin(heights.z)), 1.0)
    peak = np.unravel_index(int(np.argmax(np.where(known, smooth, -np.inf))), smooth.shape)
    # A hump of noise on a flat top is no top of its own: the level of all that is nearly as high counts.
    level = float(np.median(smooth[known & (smooth > smooth[peak] - LEVEL)]))
    parts, _ = label((smooth > min(level, float(smooth[peak])) - NEAR_TOP) & known)
    cells = np.argwhere(parts == parts[peak])
    places = heights.place(cells)
    middle = (places.min(axis=0) + places.max(axis=0)) / 2 if len(cells) < 4 else places.mean(axis=0)
    spread = np.cov((places - middle).T) if len(places) > 1 else np.zeros((2, 2))
    axes = np.linalg.eigh(spread + 1e-12 * np.eye(2))[1][:, ::-1].T
    reach = np.abs((places - middle) @ axes.T).max(axis=0)
    every = heights.place(np.argwhere(known))
    near = np.hypot(*(every - middle).T) < PATCH
    if near.sum() < FEWEST:
        raise IllConditioned("too little of the top of the object is seen; press over its middle")
    z = heights.z[known][near]
    evidence, curvatures, height = _judged(every[near] - middle, z)
    half = (float(reach[0]), float(reach[1]))
    return Top(middle, height, axes[0], half, curvatures, evidence, _another(heights, parts, int(parts[peak])))


def _another(heights: Height, parts: npt.NDArray[Any], own: int) -> Array | None:
    """Return the middle of the largest part that is as high as the top, m, where it is nearly as large."""
    sizes = np.bincount(parts.ravel())
    whole = sizes[own]
    sizes[[0, own]] = 0
    if sizes.max() < max(LARGE * whole, FEWEST):
        return None
    return np.asarray(heights.place(np.argwhere(parts == int(sizes.argmax()))).mean(axis=0))


def _judged(at: Array, z: Array) -> tuple[dict[str, float], tuple[float, float], float]:
    """Return the evidence for each kind of top, the curvatures, 1/m, and the height in the middle, m."""
    x, y = at.T
    design = np.column_stack([np.ones_like(x), x, y, x * x / 2, x * y, y * y / 2])
    fit = np.linalg.lstsq(design, z, rcond=None)[0]
    curvatures, vectors = np.linalg.eigh(-np.array([[fit[3], fit[4]], [fit[4], fit[5]]]))
    across = vectors[:, 1] if abs(curvatures[1]) >= abs(curvatures[0]) else vectors[:, 0]
    t = at @ across
    crest = np.column_stack([np.ones_like(x), x, y, t * t / 2])
    found = {}
    for kind, columns, count in (("flat", design[:, :3], 3), ("crest", crest, 5), ("round", design, 6)):
        left = z - columns @ np.linalg.lstsq(columns, z, rcond=None)[0]
        # one number for each term, by Schwarz
        found[kind] = -0.5 * float(left @ left) / FLOOR**2 / ALIKE - 0.5 * count * float(np.log(len(z) / ALIKE))
    # A top that is hollow bends the other way: it is no crest and not round.
    if max(curvatures) < abs(min(curvatures)):
        found["crest"] = found["round"] = min(found.values())
    best = max(found.values())
    large, small = sorted(curvatures, key=abs, reverse=True)
    return {kind: value - best for kind, value in found.items()}, (float(large), float(small)), float(fit[0])
