"""How many pixels share one error: the correlation area of residuals on a grid."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.shapes.sight import extent

__all__ = ["correlation_area"]

Array = npt.NDArray[np.float64]

CLEAR = 4.0  # standard deviations from which neighbours count as correlated
LOST = 0.2  # share of the correlation of neighbours below which it is not followed
MOST = 0.8  # share of the noise that a fit may have taken into its parameters and still be corrected for it


def correlation_area(x: Array, y: Array, residuals: Array, parameters: int) -> float:
    """Return the number of points that share one error, at least 1: the sum of the correlation over the plane.

    The variance of fitted parameters grows by this factor over the one by white noise, as long as the shape varies slowly
    over the area. `x`, `y` (n,) are places on a grid of any pitch, `residuals` (n,) are left by a fit of `parameters`.
    A fit takes part of correlated noise into its parameters; this part is added again. Infinite where it is most of the noise.
    """
    image, mask = _gridded(x, y, residuals)
    pairs = float((mask[1:] * mask[:-1]).sum() + (mask[:, 1:] * mask[:, :-1]).sum())
    energy = float((image * image).sum()) / max(float(mask.sum()), 1.0)
    if pairs < 16.0 or energy == 0.0:
        return 1.0
    neighbours = float((image[1:] * image[:-1]).sum() + (image[:, 1:] * image[:, :-1]).sum()) / pairs / energy
    if neighbours * np.sqrt(pairs) < CLEAR:
        return 1.0
    distance, correlation = _autocorrelation(image, mask)
    return _area(distance, correlation, parameters / float(mask.sum()))


def _gridded(x: Array, y: Array, residuals: Array) -> tuple[Array, Array]:
    """Put values on a grid whose cells hold about one point each; return their means, 0 where empty, and where it is not."""
    narrow, wide = extent(x, y)
    cell = np.sqrt(4.0 * np.pi * narrow * wide / x.size)
    # Points on a thin strip or far from the rest would ask for an endless grid.
    cell = max(cell, float(np.ptp(x)) / 400.0, float(np.ptp(y)) / 400.0)
    u, v = ((w - w.min()) / cell for w in (x, y))
    column, row = u.astype(np.intp), v.astype(np.intp)
    shape = int(row.max()) + 1, int(column.max()) + 1
    at = row * shape[1] + column
    count = np.bincount(at, minlength=shape[0] * shape[1])
    image = np.bincount(at, residuals, count.size) / np.maximum(count, 1)
    return image.reshape(shape), np.minimum(count, 1.0).reshape(shape)


def _autocorrelation(image: Array, mask: Array) -> tuple[Array, Array]:
    """Return the distance in cells and the correlation of all pairs of cells, flat, ordered by distance."""
    from scipy.fft import next_fast_len

    shape = tuple(next_fast_len(2 * n - 1, real=True) for n in image.shape)
    products, pairs = (np.fft.irfft2(np.abs(np.fft.rfft2(a, shape)) ** 2, shape) for a in (image, mask))
    rows, columns = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    distance = np.hypot(rows[:, None], columns[None, :])
    near = distance <= 0.5 * min(image.shape)
    order = np.argsort(distance[near], kind="stable")
    ratio = products[near] / np.maximum(pairs[near], 1.0)
    ratio[pairs[near] < 8.0] = 0.0
    return distance[near][order], (ratio / ratio[order[0]])[order]


def _area(distance: Array, correlation: Array, share: float) -> float:
    """Return the sum of the correlation over the plane, freed of the fit's share, and of the variance that this took.

    It is summed down to a fifth of the correlation of neighbours; below, it is lost in its own error, and taken to fall evenly to
    nothing over half that distance, which holds for a Gaussian.
    """
    ring = np.rint(distance).astype(np.intp)
    count = np.bincount(ring)
    profile = np.bincount(ring, correlation) / np.maximum(count, 1)
    if profile.size < 2:
        return 1.0
    faded = np.flatnonzero(profile[1:] < LOST * profile[1])
    end = int(faded[0]) + 1 if faded.size else profile.size
    tail = 0.5 * LOST * profile[1] * np.pi * 1.25 * (end - 0.5) ** 2
    area = 1.0
    for _ in range(20):
        taken = share * area
        if taken > MOST:
            return float("inf")
        whole = profile[1:end] * (1.0 - taken) + taken
        area, before = max(1.0 + float(whole @ count[1:end]) + tail, 1.0), area
        if abs(area - before) < 0.01 * area:
            break
    return area / (1.0 - share * area) if share * area < MOST else float("inf")
