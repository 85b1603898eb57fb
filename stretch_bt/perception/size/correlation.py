"""How many neighbouring cells share their noise."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.types import MaskArray

__all__ = ["correlation_area"]

Array = npt.NDArray[np.float64]

LAGS = 5  # cells
LEAST = 0.05  # correlation below which noise counts as independent


def correlation_area(residuals: Array, window: MaskArray) -> float:
    """Return the sum of the autocorrelation of residuals (rows, columns) over the plane, cells; at least 1.

    It is the number of cells that carry the information of one independent cell to anything that varies slowly. The
    correlation is taken as round, and as ended where its mean over a ring falls below 0.05.
    """
    image, mask = np.where(window, residuals, 0.0), window.astype(np.float64)
    limit = 4.0 * float(np.sqrt((image * image).sum() / max(mask.sum(), 1.0)))
    image = np.clip(image, -limit, limit)
    pairs = [
        (v, u) for v in range(LAGS + 1) for u in range(-LAGS, LAGS + 1) if (v > 0 or u > 0) and v * v + u * u <= LAGS**2
    ]
    sums = np.array([[_shifted(image, *lag), _shifted(mask, *lag)] for lag in pairs])
    ring = np.rint(np.hypot(*np.array(pairs).T)).astype(int)
    variance = float((image * image).sum() / max(mask.sum(), 1.0))
    area = 1.0
    for distance in range(1, LAGS + 1):
        total, count = sums[ring == distance].sum(axis=0)
        mean = total / max(count, 1.0) / max(variance, 1e-300)
        if mean < LEAST:
            break
        area += 2.0 * mean * np.count_nonzero(ring == distance)
    return float(area)


def _shifted(image: Array, v: int, u: int) -> float:
    """Return the sum of products of an image with itself, shifted by v >= 0 rows and u columns."""
    rows, columns = image.shape
    if u >= 0:
        first, second = image[v:, u:], image[: rows - v, : columns - u]
    else:
        first, second = image[v:, :u], image[: rows - v, -u:]
    return float(np.vdot(first, second))
