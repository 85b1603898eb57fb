"""How a held membrane differs from a room: it stands in its plane at the ends that hold it, nowhere far behind or before it, and is whole."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.regions import opened, valid_box
from stretch_bt.perception.robust import quantile, sample
from stretch_bt.perception.surface import Cleaned, Surface
from stretch_bt.perception.types import MaskArray

__all__ = ["check_held"]

# `python -m benchmarks.no_membrane`: solved presses to 30 mm deep at stretches of 0 to 60 mm, with 1 mm of noise, reach 0.07 at the
# ends and have nothing of themselves behind the plane; 3 of some 800 frames of people at 0.45 to 1 m, wherever their plane is said to be, keep
# to all three. Past the sides that a press of 30 mm draws in, a table is 7 % of what is seen.
END = 0.1  # share of the length seen: how far the median of an end may stand off the plane
STRIP = 0.05  # share of the length seen that counts as its end
BEHIND = 0.1  # share of the length seen: how far a membrane hangs behind its plane at most
FEW = 0.1  # share of the pixels that may lie farther behind, beside single ones that fly
HIGHEST = 0.7  # share of the length seen: how far a membrane stands before its plane at most
# A slope that no membrane has over so many pixels: presses 30 mm deep have 4. Noise may be as steep: m, and medians of all steps, beyond it.
STEEP, APART, LEAST_STEP, BY_CHANCE = 6.0, 3, 5e-3, 10.0
TORN = 30  # steps on every second line, at least: a clear edge is some 20 pixels long
SHORTEST = 0.06  # m: where less of a membrane is seen, all of it may be lifted
LEAST = 8  # fewest bins along each side that show ends

Image = npt.NDArray[np.float32]


def check_held(cleaned: Cleaned, surface: Surface) -> None:
    """Raise IllConditioned unless points in the membrane frame may belong to a membrane held in the plane z = 0.

    Either the first and last rows or the first and last columns must stand near the plane; a side that an object lifts may leave it.
    A step from the surface to what lies far behind it is a side's; any other step is an edge of an object that no membrane covers.
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
    steps = _steps(cleaned, -BEHIND * length)
    if steps.size >= TORN:
        raise IllConditioned(
            f"this is no membrane: the surface seen has edges where it falls by {1e3 * float(np.median(steps)):.0f} mm from one pixel to the next;"
            " look where the camera points, and leave out what is not the membrane (`mask_membrane`)"
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


def _steps(cleaned: Cleaned, behind: float) -> Image:
    """Return the steps (n,), m, between pixels so close that no membrane has them, but for those to what lies `behind`, m."""
    least = max(STEEP * APART * cleaned.pitch, LEAST_STEP)
    return np.concatenate([_steps_down(z, seen, least, behind - cleaned.level) for z, seen in _both_ways(cleaned)])


def _both_ways(cleaned: Cleaned) -> list[tuple[Image, MaskArray]]:
    """Return every second column, and every second row as a column."""
    z, seen = cleaned.height, cleaned.valid
    return [(z[:, ::2], seen[:, ::2]), (z[::2].T, seen[::2].T)]


def _steps_down(z: Image, seen: MaskArray, least: float, behind: float) -> Image:
    """Return the steps (n,), m, down the columns of an image (h, w)."""
    step, both = np.abs(z[APART:] - z[:-APART]), seen[APART:] & seen[:-APART]
    torn = both & (step > np.float32(least))
    if torn.any():
        torn &= (step > np.float32(BY_CHANCE * quantile(sample(step, both)))) & (
            np.minimum(z[APART:], z[:-APART]) > np.float32(behind)
        )
    return np.asarray(step[torn])


def _off(height: Image, seen: MaskArray) -> float:
    """Return how far the first or the last rows stand off the plane, m: the median of the end that stands farther."""
    strip = max(2, round(STRIP * len(height)))
    ends = [np.median(height[rows][seen[rows]]) for rows in (slice(strip), slice(-strip, None))]
    return float(max(ends, key=abs))
