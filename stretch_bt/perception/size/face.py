"""The face of a contact, and whether it is seen to be flat."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.size.cells import HeightCells
from stretch_bt.perception.size.fit import Fit
from stretch_bt.perception.size.hypothesis import Hypothesis, Value

__all__ = ["check_flat", "maybe_wider"]

FACE, FEWEST = 1.5e-3, 12  # m inside the rim from where the face is flat, and the fewest cells to judge it by
ROUND, LEAST_BOW = 5.0, 0.3e-3  # standard deviations, and m: least height of the middle of a round face above its rim
#: m^2 of a face from which it is one: balls on a hardly stretched membrane leave a circle up to 3e-6 and other outlines up to 10e-6, flat
#: tops of 8 mm 7e-6 and 13e-6 or more
SEEN, SEEN_OF_OTHERS = 4e-6, 11e-6
MAYBE = (
    0.5  # share of a width's difference from the labelled one that counts as its error where the face is hardly seen
)


def check_flat(shape: Hypothesis, fit: Fit, cells: HeightCells) -> None:
    """Raise IllConditioned where the middle of a face stands clearly above or below its rim."""
    bow, sd = _bow(shape, fit, cells)
    if bow > ROUND * sd and bow > LEAST_BOW:
        raise IllConditioned("the face in contact is round, not flat: fit a sphere to it")
    if bow < -ROUND * sd and bow < -LEAST_BOW:
        raise IllConditioned(
            "the middle of the contact lies lower than its rim: there are several contacts, or a hollow one;"
            " measure one contact at a time, or press less deep"
        )


def maybe_wider(shape: Hypothesis, fit: Fit, cells: HeightCells, width: float) -> float:
    """Return the error of a width, m, where too little of a face is seen to distinguish it from a ball: a membrane bends over both alike.

    Raises
    ------
    IllConditioned
        Too little of the face is seen, and its outline is no circle, as a ball's would be.
    """
    round_ = shape.name == "circle"
    face = np.count_nonzero(_within(shape, fit, cells)[2]) * cells.area
    if face >= (SEEN if round_ else SEEN_OF_OTHERS):
        return 0.0
    if not round_:
        raise IllConditioned(
            "the flat face that fits best is too small for its flatness to be seen, and a ball looks alike: fit a sphere to it,"
            " stretch the membrane more, or name a shape (`hypothesis`) to take it for granted"
        )
    labelled = 2.0 * math.sqrt(np.count_nonzero(cells.valid & (cells.touching > 0.5)) * cells.area / math.pi)
    return MAYBE * max(labelled - width, 0.0)


def _within(
    shape: Hypothesis, fit: Fit, cells: HeightCells
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Return x and y, m, of the cells that were fitted, and which of them lie within the face."""
    x, y = cells.x[fit.window], cells.y[fit.window]
    return x, y, shape.outside(fit.q, x, y) < -FACE


def _bow(shape: Hypothesis, fit: Fit, cells: HeightCells) -> Value:
    """Return how far the middle of the face stands above its ends, m, along the axis where this is clearest.

    It is the residual of the face to a plane, as a paraboloid over the face's own axes.
    """
    x, y, face = _within(shape, fit, cells)
    if np.count_nonzero(face) < FEWEST:
        return 0.0, 1.0
    places = np.stack([x[face], y[face]]) - np.array([[x[face].mean()], [y[face].mean()]])
    axes = np.linalg.eigh(places @ places.T)[1].T @ places
    reach = np.abs(axes).max(axis=1)
    if not reach.min() > 1e-6 * reach.max():  # one row of cells, which has no middle across
        return 0.0, 1.0
    design = np.vstack([np.ones(axes.shape[1]), (axes / reach[:, None]) ** 2])
    normal = np.linalg.inv(design @ design.T)
    bows = -(normal @ design @ fit.residuals[fit.window][face])[1:]
    sds = fit.noise * np.sqrt(np.diag(normal)[1:] * fit.area)
    clearest = int(np.argmax(np.abs(bows) / sds))
    return float(bows[clearest]), float(sds[clearest])
