"""Which of a membrane that stays while the hand rises lies on something: by how it bends.

Between two domes, or inside a ring of wire, a membrane hangs freely and stays all the same. Its shape shows that. A free membrane in
tension obeys T_i z_xx + T_j z_yy = 0, so that where it is bent it is a saddle; one that lies on something is pressed against it
and bends down more than that, or lies flat on a face. A flat part that is a saddle as a whole is no face.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.clouds.expected import TENSIONS

__all__ = ["bends", "bends_along", "supported"]

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

SECOND = ((2, 0), (0, 2), (1, 1))  # orders of the second derivatives
SCALE, SMEARED = 2.0, 3  # cells that curvatures are smoothed over, and how much wider a bend seems on either side
ROUNDS = 6  # until slopes at a border have settled
FLAT = 12.0  # 1/m: less is called flat
LEAST, SURE = 6.0, 3.0  # 1/m, and standard deviations: least curvature of a load
FALL = 0.35  # least curvature of the load over the largest one near by, up to where it ends
SHARE = (
    0.12  # least curvature of the load over the membrane's largest; under a cylinder across the hand it is a quarter
)
RIM = 4  # cells: rim of a flat part that may bend
WIDE = 6.0  # cells: least radius of the rest for a test of its shape as a whole
HANGS, NOISE = 0.05e-3, 4.0  # m, and standard deviations: least rise towards its rim of a flat part that hangs
ALIKE = 36.0  # cells that err as one
GAP, SPECK = 2, 10  # cells: half a gap between parts that is closed, and a part that is noise when smaller


@dataclass(frozen=True, slots=True)
class _Bent:
    """Curvatures (n, m), 1/m, positive where convex: the load's, and the two principal ones."""

    load: Array
    most: Array
    least: Array


def supported(heights: Array, stays: Mask, *, turn: float, cell: float) -> tuple[Mask, Mask]:
    """Return which cells of a membrane that stays lie on something, and which hang for sure, each (n, m) bool.

    Parameters
    ----------
    heights : (n, m) float, m
        Heights of the membrane over cells along the world's x and y, NaN where it was not seen.
    stays : (n, m) bool
        Where it stays while the hand rises.
    turn : float, rad
        Turn of the hand about the vertical; its clamps hold the membrane along its own y.
    cell : float, m
        Width of a cell.
    """
    from scipy.ndimage import binary_dilation

    if not stays.any():
        return stays, stays
    bent = _curvatures(heights, turn, cell)
    noise = _scatter(bent.load[np.isfinite(heights) & ~stays])
    sure = max(LEAST, SURE * noise)
    loaded = _loaded(bent, sure)
    flat = stays & _closed((np.abs(bent.most) < FLAT) & (np.abs(bent.least) < FLAT), 1)
    hollow = stays & binary_dilation(_hollow(heights, flat), iterations=SMEARED)
    hangs = hollow | (~flat & ~loaded & (bent.least < -sure))
    lies = _closed(loaded | flat, GAP) & stays & ~hangs
    return _large(lies), np.asarray(stays & hangs)


def _closed(mask: Mask, gap: int) -> Mask:
    """Return a mask with its gaps filled, also those at the border of what was seen."""
    from scipy.ndimage import binary_closing

    return np.asarray(
        binary_closing(np.pad(mask, gap + 1, mode="edge"), iterations=gap)[gap + 1 : -gap - 1, gap + 1 : -gap - 1]
    )


def _loaded(bent: _Bent, sure: float) -> Mask:
    """Return where the load's curvature is surely one, and beside that as far as it is a share of it."""
    from scipy.ndimage import maximum_filter

    seeds = bent.load > sure
    near = maximum_filter(np.where(seeds, bent.load, -np.inf), size=2 * SMEARED + 1)
    return np.asarray(
        (seeds | (bent.load > np.maximum(FALL * near, sure / 2))) & (near > 0) & (bent.load > SHARE * bent.most)
    )


def bends(heights: Array, *, cell: float) -> tuple[Array, Array]:
    """Return the principal curvatures (n, m), 1/m, the larger first, positive where convex, of heights (n, m), m, NaN where unknown."""
    bent = _curvatures(heights, 0.0, cell)
    return bent.most, bent.least


def bends_along(heights: Array, at: Array, steps: Array, *, cell: float) -> Array:
    """Return how a surface bends (2, k, n), 1/m, positive where convex: up its slope, and along its largest bend, at steps from places.

    The second counts where a surface falls to two sides, as beyond the end of a crest: its slope does not lead to that end.

    Parameters
    ----------
    heights : (p, q) float, m
        Heights of the surface over cells, NaN where unknown.
    at : (2, n) float, cells
        Places; whole numbers are middles of cells.
    steps : (k,) float, cells
    cell : float, m
        Width of a cell.
    """
    from scipy.ndimage import map_coordinates

    def there(values: Array, places: Array) -> Array:
        return np.asarray(map_coordinates(values, places, order=1, mode="nearest"))

    up = np.stack([there(slope, at) for slope in _derivatives(heights, ((1, 0), (0, 1)))])
    seconds = [-d / cell**2 for d in _derivatives(heights, SECOND)]
    xx, yy, xy = (there(d, at) for d in seconds)
    turn = np.arctan2(2 * xy, xx - yy) / 2
    most = np.stack([np.cos(turn), np.sin(turn)])
    most *= np.where((most * up).sum(axis=0) < 0, -1.0, 1.0)

    def along(way: Array) -> Array:
        weights = way[0] ** 2, way[1] ** 2, 2 * way[0] * way[1]
        places = at[:, None] + steps[:, None] * way[:, None]
        return np.asarray(sum(w * there(d, places) for w, d in zip(weights, seconds, strict=True)))

    return np.stack([along(up / np.maximum(np.linalg.norm(up, axis=0), 1e-12)), along(most)])


def _derivatives(heights: Array, orders: tuple[tuple[int, int], ...]) -> list[Array]:
    """Return smoothed derivatives, each (n, m), by cells, of heights (n, m), m, NaN where unknown."""
    from scipy.ndimage import gaussian_filter

    beyond = round(4 * SCALE)
    z = _continued(np.pad(heights, beyond, constant_values=np.nan))
    inner = slice(beyond, -beyond), slice(beyond, -beyond)
    return [gaussian_filter(z, SCALE, order=order)[inner] for order in orders]


def _curvatures(heights: Array, turn: float, cell: float) -> _Bent:
    xx, yy, xy = (d / cell**2 for d in _derivatives(heights, SECOND))
    c, s = np.cos(turn), np.sin(turn)
    along, across = s * s * xx - 2 * s * c * xy + c * c * yy, c * c * xx + 2 * s * c * xy + s * s * yy
    mean, half = -(xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    return _Bent(-(TENSIONS * along + across) / (TENSIONS + 1), mean + half, mean - half)


def _continued(heights: Array) -> Array:
    """Return heights, m, about 0, that go on straight where nothing was seen: level, they would seem to bend at a border."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter

    unknown = np.isnan(heights)
    nearest = tuple(distance_transform_edt(unknown, return_distances=False, return_indices=True))
    away = np.indices(heights.shape) - np.array(nearest)
    z = heights[nearest]
    known = z = z - z.mean()
    for _ in range(ROUNDS if unknown.any() else 0):
        slopes = [gaussian_filter(z, SCALE, order=o)[nearest] for o in ((1, 0), (0, 1))]
        z = np.where(unknown, known + away[0] * slopes[0] + away[1] * slopes[1], known)
    return np.asarray(z)


def _large(cells: Mask) -> Mask:
    """Return the cells without specks, which noise makes."""
    from scipy.ndimage import label

    parts, _ = label(cells)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return np.asarray(sizes[parts] >= SPECK)


def _scatter(values: Array) -> float:
    """Return the standard deviation of most of the values, 0 of none."""
    return 1.4826 * float(np.median(np.abs(values))) if len(values) else 0.0


def _hollow(heights: Array, flat: Mask) -> Mask:
    """Return the flat parts that are wide enough for the test and rise towards two sides."""
    from scipy.ndimage import binary_erosion, label

    parts, count = label(flat)
    inner = np.where(binary_erosion(flat, iterations=RIM), parts, 0)
    sizes = np.sqrt(np.bincount(inner.ravel(), minlength=count + 1) / np.pi)
    hangs = [k for k in range(1, count + 1) if sizes[k] > WIDE and _rises(heights, inner == k, float(sizes[k]))]
    return np.asarray(np.isin(parts, hangs))


def _rises(heights: Array, part: npt.NDArray[Any], size: float) -> bool:
    """Whether a part bends up along some direction, by more over its half width than noise or a face explains."""
    at = np.argwhere(part).astype(np.float64)
    x, y = ((at - at.mean(axis=0)) / size).T
    design = np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    fit = np.linalg.lstsq(design, heights[part], rcond=None)[0]
    left = float(np.std(heights[part] - design @ fit))
    up = float(np.linalg.eigvalsh([[fit[3], fit[4] / 2], [fit[4] / 2, fit[5]]])[1])
    return bool(up > max(HANGS, NOISE * left * np.sqrt(ALIKE / len(x))))
