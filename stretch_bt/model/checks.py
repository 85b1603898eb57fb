"""Requirements on the numbers of a calibration file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.plain_numbers import is_number

__all__ = ["MOST_SD", "require_correlation", "require_covariance", "require_within"]

#: most that a model may leave of a force, as a part of it
MOST_SD = 3.0
_ROUNDING = 1e-9  # of the largest variance over the deviations of two parameters


def require_within(name: str, value: object, low: float, high: float) -> None:
    """Raise InvalidInput, with the name of the field, unless a value is a number within bounds."""
    if not (is_number(value) and low <= value <= high):
        raise InvalidInput(f"{name}: it is a number from {low:.6g} to {high:.6g}, not {value!r}")


def require_covariance(name: str, rows: Sequence[Sequence[float]], size: int) -> None:
    """Raise InvalidInput, with the name of the field, unless rows are a covariance (size, size): symmetric, and of no negative variance."""
    if len(rows) != size or not all(len(row) == size and all(map(is_number, row)) for row in rows):
        raise InvalidInput(f"{name}: it has {size} rows of {size} finite numbers")
    matrix = np.array(rows, float)
    variances = np.diag(matrix)
    if (variances < 0).any():
        raise InvalidInput(f"{name}: a variance is not below 0, as {variances.min():g} is")
    sds = np.sqrt(variances)
    scale = np.where(sds > 0, sds, 1.0)
    shares = matrix / np.outer(scale, scale)
    if np.abs(shares - shares.T).max() > _ROUNDING or (matrix[sds == 0] != 0).any():
        raise InvalidInput(f"{name}: it is not symmetric, or correlates what has no deviation")
    if np.linalg.eigvalsh((shares + shares.T) / 2).min() < -_ROUNDING:
        raise InvalidInput(f"{name}: some sum of the parameters has a variance below 0; it is no covariance")


def require_correlation(name: str, rows: Sequence[Sequence[float]], size: int) -> None:
    """Raise InvalidInput, with the name of the field, unless rows are a correlation (size, size): a covariance of variances 1."""
    require_covariance(name, rows, size)
    variances = np.diag(np.array(rows, float))
    if np.abs(variances - 1.0).max() > _ROUNDING:
        raise InvalidInput(
            f"{name}: each parameter is correlated by 1 with itself, not by {variances[np.abs(variances - 1.0).argmax()]:g}"
        )
