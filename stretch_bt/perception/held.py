"""How a held membrane differs from a room: it stands in its plane at the ends that hold it, nowhere far behind or before it, and has no edges."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.regions import closed, opened, valid_box
from stretch_bt.perception.robust import quantile, sample
from stretch_bt.perception.surface import Cleaned, Surface
from stretch_bt.perception.types import MaskArray

__all__ = ["check_held"]

# `python -m benchmarks.no_membrane`: solved presses to 30 mm deep at stretches of 0 to 60 mm, with 1 mm of noise, reach 0.07 at the
# ends and have nothing of themselves behind the plane; 1 of some 800 frames of people at 0.45 to 1 m, wherever their plane is said to be, keeps
# to all bounds. Past the sides that a press of 30 mm draws in, a table is 7 % of what is seen.
END = 0.1  # share of the length seen: how far the median of an end may stand off the plane
STRIP = 0.05  # share of the length seen that counts as its end
BEHIND = 0.1  # share of the length seen: how far a membrane hangs behind its plane at most
FEW = 0.1  # share of the pixels that may lie farther behind, beside single ones that fly
HIGHEST = 0.7  # share of the length seen: how far a membrane stands before its plane at most
# Slope over so many pixels that no membrane has: presses 30 mm deep have 4. A step is larger than LEAST_STEP, m, too, and than BY_CHANCE times the
# median step, since noise can be as steep.
STEEP, APART, LEAST_STEP, BY_CHANCE = 6.0, 3, 5e-3, 10.0
CLOSED = 5  # pixels along a side, of holes that part nothing
LEAST_AREA = 16e-6  # m^2, of an object beyond its edge: clumps of flying pixels and cables are smaller or thinner
SHORTEST = 0.06  # m: where less of a membrane is seen, all of it may be lifted
LEAST = 8  # fewest bins along each side that show ends

Image = npt.NDArray[np.float32]


def check_held(cleaned: Cleaned, surface: Surface) -> None:
    """Raise IllConditioned unless points in the membrane frame may belong to a membrane held in the plane z = 0.

    Either the first and last rows or the first and last columns must stand near the plane; a side that an object lifts may leave it.
    What stands before the plane must hang together with an end in it: an object before a wall is parted from the wall by its edge.
    `surface` is the surface of the cleaned points, which lack points far behind.
    """
    box = valid_box(surface.valid)
    seen, height = surface.valid[box], surface.smooth[box] + np.float32(surface.level)
    if min(seen.shape) < LEAST:
        return
    length = max(seen.shape) * surface.pitch
    if length < SHORTEST:
        return
    behind = _share_behind(cleaned, BEHIND * length)
    if behind > FEW:
        raise IllConditioned(
            f"this is no membrane: {100 * behind:.1f} % of the surface seen lies more than {1e3 * BEHIND * length:.0f} mm behind the plane of the"
            " flat membrane; look where the camera points, correct `plane_distance`, and leave out what is not the membrane (`mask_membrane`)"
        )
    highest = float(np.max(height, where=seen, initial=0.0))
    if highest > HIGHEST * length:
        raise IllConditioned(
            f"this is no membrane, or none in its plane: the surface seen, {1e3 * length:.0f} mm long, rises {1e3 * highest:.0f} mm above the plane"
            " of the flat membrane; look where the camera points, and correct `plane_distance`"
        )
    apart = _apart(cleaned, END * length)
    if apart is not None:
        raise IllConditioned(
            f"this is no membrane: a part of the surface seen stands {1e3 * apart:.0f} mm before the plane of the flat membrane, with edges that"
            " are too steep for a membrane; look where the camera points, and leave out what is not the membrane (`mask_membrane`)"
        )
    off = min(_off(height, seen), _off(height.T, seen.T), key=abs)
    if abs(off) > END * length:
        raise IllConditioned(
            f"this is no membrane, or none in its plane: an end of the surface seen stands {1e3 * off:.0f} mm out of the plane of the flat"
            " membrane, where the fingers hold it; look where the camera points, correct `plane_distance`, and let all of the membrane be seen"
        )


def _share_behind(cleaned: Cleaned, far: float) -> float:
    """Return the share of the pixels seen that lie more than `far`, m, behind the plane, in patches of three by three and more."""
    rows, columns = cleaned.box
    z = cleaned.points[rows].reshape(rows.stop - rows.start, -1, 3)[:, columns, 2]
    behind: MaskArray = cleaned.seen & (z < -far)
    seen = int(np.count_nonzero(cleaned.seen))
    return int(np.count_nonzero(opened(behind))) / seen if behind.any() else 0.0


def _apart(cleaned: Cleaned, beside: float) -> float | None:
    """Return how far a part of the surface stands before the plane, m, that edges part from all ends `beside` the plane, m; None without one.

    A part that one side of the view cuts off, as a finger, does not count.
    """
    import cv2

    cut = _edges(cleaned)
    if not cut.any():
        return None
    whole = closed(cleaned.valid, CLOSED) & ~cut
    count, parts, stats, _ = cv2.connectedComponentsWithStats(whole.view(np.uint8), connectivity=4)
    least = LEAST_AREA / cleaned.pitch**2
    for number in (n for n in range(1, count) if stats[n, cv2.CC_STAT_AREA] > least):
        part: MaskArray = cleaned.valid & (np.asarray(parts) == number)
        high = float(np.median(cleaned.height[part])) + cleaned.level if part.any() else 0.0
        if high > LEAST_STEP and not _is_held(cleaned, part, beside):
            return high
    return None


def _is_held(cleaned: Cleaned, part: MaskArray, beside: float) -> bool:
    """Whether a part stands beside the plane at an end of the view, or is cut off at one side."""
    strip = max(2, round(STRIP * max(part.shape)))
    near: MaskArray = part & (np.abs(cleaned.height + np.float32(cleaned.level)) < beside)
    held, rim = ([m[:strip].any(), m[-strip:].any(), m[:, :strip].any(), m[:, -strip:].any()] for m in (near, part))
    crosses = all(rim[:2]) or all(rim[2:])
    return any(held) or (any(rim) and not crosses)


def _edges(cleaned: Cleaned) -> MaskArray:
    """Return the pixels over which the surface is too steep for a membrane."""
    cut = np.zeros(cleaned.valid.shape, dtype=bool)
    least = np.float32(max(STEEP * APART * cleaned.pitch, LEAST_STEP))
    for z, seen, found in ((cleaned.height, cleaned.valid, cut), (cleaned.height.T, cleaned.valid.T, cut.T)):
        step, both = np.abs(z[APART:] - z[:-APART]), seen[APART:] & seen[:-APART]
        torn = both & (step > least)
        if torn.any():
            torn &= step > np.float32(BY_CHANCE * quantile(sample(step, both)))
            for row in range(APART + 1):
                found[row : row + len(torn)] |= torn
    return cut


def _off(height: Image, seen: MaskArray) -> float:
    """Return how far the first or the last rows stand off the plane, m: the median of the end that stands farther."""
    strip = max(2, round(STRIP * len(height)))
    ends = [np.median(height[rows][seen[rows]]) for rows in (slice(strip), slice(-strip, None))]
    return float(max(ends, key=abs))
