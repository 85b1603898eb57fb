"""Where a contact is and how large, roughly: from its heights, with the labels to say where to look."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, NoContact
from stretch_bt.perception.size.cells import HeightCells
from stretch_bt.perception.types import MaskArray

__all__ = ["HIGH", "Start", "start_of"]

Array = npt.NDArray[np.float64]

SMOOTH = 2.0  # cells
LEVEL = 0.72  # share of the top above which a place counts as part of the contact, skirt included
HIGH = 0.6  # share above which a part labelled as in contact may be a contact of its own; folds of a slack sheet that are labelled lie below
LARGE = 10e-6  # m^2 of such a part, from which it is one
VALLEY = 0.1  # least drop of the membrane between two contacts, as a share of the top


@dataclass(frozen=True, slots=True)
class Start:
    """Centre (x, y), m, height of the top, m, and standard deviations of the raised part along its axes, m.

    `angle`, rad, is the angle of the first axis from x; `across` and `along` are the deviations along x and y.
    """

    x: float
    y: float
    top: float
    across: float
    along: float
    major: float
    minor: float
    angle: float


def start_of(cells: HeightCells) -> Start:
    """Return the raised part around the contact's highest place.

    Raises
    ------
    NoContact
        Nothing is raised where the labels say that there is contact.
    IllConditioned
        Two separate parts are raised as high.
    """
    height = _smoothed(cells.height, cells.valid, SMOOTH)
    likely = _smoothed(cells.touching, cells.valid, SMOOTH)
    if not (cells.valid & (likely > 0.3 * likely.max())).any() or not likely.max() > 0.0:
        raise NoContact(
            "no pixel labelled as in contact has depth; give the labels of this very frame, and keep reflections off the membrane"
        )
    peak = np.unravel_index(
        int(np.argmax(np.where(cells.valid & (likely > 0.3 * likely.max()), height, -np.inf))), height.shape
    )
    top = _top(height, cells, peak)
    if not top > 0.0:
        raise NoContact(
            "the pixels labelled as in contact do not rise above the undeformed membrane: they touch nothing;"
            " press deeper, or look at `plane_distance` of the cell"
        )
    _refuse_two(height, cells, top)
    part = _part(cells.valid & (height > LEVEL * top), peak)
    x, y = cells.x[part], cells.y[part]
    if not x.size:
        raise IllConditioned(
            "nothing in the frame stands above the undeformed membrane: there is nothing to measure; press deeper"
        )
    middle = float(x.mean()), float(y.mean())
    spread = np.cov(x, y, bias=True) if x.size > 2 else np.zeros((2, 2))
    values, vectors = np.linalg.eigh(spread + 1e-8 * np.eye(2))
    angle = float(np.arctan2(vectors[1, 1], vectors[0, 1]))
    deviations = np.sqrt(values)
    across, along = (float(d) for d in np.sqrt(np.diag(spread) + 1e-8))
    return Start(*middle, top, across, along, float(deviations[1]), float(deviations[0]), angle)


def _smoothed(values: Array, valid: MaskArray, sigma: float) -> Array:
    from stretch_bt.perception.smooth import smooth

    return np.asarray(smooth(values.astype(np.float32), valid.astype(np.float32), sigma)[0], dtype=np.float64)


def _top(height: Array, cells: HeightCells, peak: tuple[np.intp, ...]) -> float:
    """Return the height of the face around a peak, m: the 80th percentile nearby."""
    reach = (max(2, round(6e-3 / pitch)) for pitch in reversed(cells.pitches))
    rows, columns = (slice(max(int(p) - n, 0), int(p) + n + 1) for p, n in zip(peak, reach, strict=True))
    return float(np.quantile(height[rows, columns][cells.valid[rows, columns]], 0.8))


def _part(mask: MaskArray, place: tuple[np.intp, ...]) -> MaskArray:
    """Return the connected part of a mask around a place."""
    import cv2

    _, parts = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    found: MaskArray = parts == parts[place]
    return found & mask


def _refuse_two(height: Array, cells: HeightCells, top: float) -> None:
    """Raise where two parts labelled as in contact are both high and a valley lies between them."""
    import cv2

    labelled = (cells.touching > 0.5) & (height > HIGH * top)
    count, parts, stats, centroids = cv2.connectedComponentsWithStats(labelled.astype(np.uint8), connectivity=8)
    large = [n for n in range(1, count) if stats[n, cv2.CC_STAT_AREA] * cells.area > LARGE]
    if len(large) < 2:
        return
    noise = float(np.std((cells.height - height)[cells.valid]))
    least = max(VALLEY * top, 4.0 * noise)
    largest = max(large, key=lambda n: stats[n, cv2.CC_STAT_AREA])
    for other in (n for n in large if n != largest):
        line = np.linspace(centroids[largest], centroids[other], 60).round().astype(int)
        between = float(height[line[:, 1], line[:, 0]].min())
        if between < min(np.median(height[parts == n]) for n in (largest, other)) - least:
            raise IllConditioned(
                "there are two separate contacts; measure one at a time, with the pixels of the other labelled 255"
            )
