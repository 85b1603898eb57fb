"""How much of an object's surface the lowest membrane of all presses shows, felt or not.

That membrane lies on the object or above it. Just beyond where it was felt to lie it is still close: a membrane that resists bending
leaves a flank before it would be tangent to it, and one that is pulled tight rises with the hand where it has lifted by a hair. Its shape
shows that it has not left for good: as long as it follows the object it goes on bending as it does where it was felt, and
where it hangs free it is a saddle.

An edge holds such a membrane up on a line, off which it lifts to both sides: over a flat top it touches the rim alone and spans the rest
as a drum does, a fraction of a millimetre above it. Within a closed rim the lowest membrane therefore shows a face as well, or a hole: only
the shape can say which.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.clouds.cloud import Cloud, cloud_of
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.seen import FEWEST
from stretch_bt.perception.clouds.support import bends

__all__ = ["NEARBY", "told", "told_points"]

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

REACH = 3.0  # cells beyond what was felt
#: cells, where the lowest presses of two poses agree to within so much, m: held up otherwise, a free membrane would not
TWICE = (6.0, 0.1e-3)
#: 1/m, bend from which the surface felt ends at an edge, and cells that the membrane is then followed beyond: it bends on without it
EDGE = (60.0, 1.0)
HOLLOW = 20.0  # 1/m that a membrane which lies on something may bend up: smoothing leaves as much of a saddle beside it
#: cells, half a gap that a rim may have, and m above or below the rim nearby within which a membrane that spans it shows a face
GAP, SPAN = 1, 1.0e-3
#: how much less it may bend than where it was felt, in 1/m, or shares of the larger and the smaller bend there: off a dome it goes by and by
ALIKE = (12.0, 0.2, 0.3)
NEARBY = (
    1.0e-3  # m, standard deviation of a place that is shown but was not felt, by `python -m benchmarks.reconstruct`
)


def told(relief: Relief) -> Mask:
    """Return the cells (n, m) of a map whose lowest membrane shows the object's surface: felt ones, without specks, and others beside them."""
    from scipy.ndimage import distance_transform_edt, label

    felt = _large(relief.felt)
    if not felt.any():
        return felt
    seen = np.isfinite(relief.ceiling)
    most, least = _bends(relief, seen)
    far, near = distance_transform_edt(~felt, return_indices=True)
    there, other = most[tuple(near)], least[tuple(near)]
    follows = seen & (least > -HOLLOW) & (most > there - np.maximum(ALIKE[0], ALIKE[1] * there + ALIKE[2] * other))
    reach = np.where(there > EDGE[0], EDGE[1], np.where(_agreed(relief), TWICE[0], REACH))
    parts, _ = label(felt | (follows & (far <= reach)))
    beside = (parts > 0) & np.isin(parts, np.unique(parts[felt]))
    return np.asarray(beside | _spanned(relief, beside))


def _spanned(relief: Relief, rim: Mask) -> Mask:
    """Return where the membrane spans the inside of a closed rim of such cells, about as high as the rim."""
    from scipy.ndimage import binary_closing, binary_fill_holes, distance_transform_edt, label

    closed = binary_closing(np.pad(rim, GAP + 1), iterations=GAP)[GAP + 1 : -GAP - 1, GAP + 1 : -GAP - 1]
    inside = np.asarray(binary_fill_holes(closed)) & ~rim & np.isfinite(relief.ceiling)
    near = tuple(distance_transform_edt(~rim, return_distances=False, return_indices=True))
    off = inside & ~(np.abs(relief.ceiling - relief.ceiling[near]) < SPAN)
    parts, _ = label(inside)
    return np.asarray(inside & ~np.isin(parts, np.unique(parts[off])))


def told_points(cloud: Cloud, relief: Relief) -> Cloud:
    """Return a cloud of the world with one more point in each cell that `told` returns and that holds none, and without points in others."""
    known = told(relief)
    x, y = cloud.points[:, 0], cloud.points[:, 1]
    kept = cloud.part(relief.at(known, x, y, False))
    cells = np.floor(kept.points[:, :2] / relief.cell).astype(np.int64) - relief.origin
    known[tuple(cells.T)] = False
    places = np.column_stack([relief.place(np.argwhere(known)), relief.ceiling[known]])
    # what contacts disagree by is no error of these points
    more = cloud_of(places, NEARBY / max(cloud.disagreement, 1.0), floor=cloud.floor)
    both: dict[str, Any] = {
        name: np.concatenate([getattr(kept, name), getattr(more, name)])
        for name in ("points", "noise", "rays", "columns")
    }
    apart = None if kept.apart is None else np.concatenate([kept.apart, np.zeros(len(more))])
    return replace(kept, **both, seen=np.concatenate([kept.seen, 0 * more.seen]), apart=apart)


def _bends(relief: Relief, seen: Mask) -> tuple[Array, Array]:
    """Return the larger and the smaller bend (n, m), 1/m, of the lowest membrane, NaN around the part of the map that holds all that was seen."""
    from scipy.ndimage import find_objects

    part = find_objects(seen.astype(np.int64))[0]
    most, least = np.full(seen.shape, np.nan), np.full(seen.shape, np.nan)
    most[part], least[part] = bends(np.where(seen, relief.ceiling, np.nan)[part], cell=relief.cell)
    return most, least


def _agreed(relief: Relief) -> Mask:
    """Return where two presses from different poses bound the object alike."""
    agreed = np.zeros(relief.ceiling.shape, dtype=bool)
    if relief.second is not None:
        known = np.isfinite(relief.second)
        agreed[known] = relief.second[known] - relief.ceiling[known] < TWICE[1]
    return agreed


def _large(felt: Mask) -> Mask:
    """Return the felt cells without parts that are too small to count."""
    from scipy.ndimage import label

    parts, _ = label(felt, np.ones((3, 3), dtype=np.int64))
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return np.asarray(sizes[parts] >= FEWEST)
