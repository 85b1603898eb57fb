"""From a convex part of the membrane to the whole contact: round tops up to their edge, flat faces up to their rim."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.regions import (
    Box,
    bounds,
    filled,
    hull,
    inner_half,
    placed,
    touching,
    widened,
    with_rim,
)
from stretch_bt.perception.scale import Signal
from stretch_bt.perception.smooth import laplacian
from stretch_bt.perception.surface import Surface
from stretch_bt.perception.types import MaskArray

__all__ = ["Patch", "flat_or_round", "highest", "holds_summit", "with_above_plane"]

Image = npt.NDArray[np.float32]

SHARE = 0.9  # share of the top's height from which a place counts as the top
SHARE_SD = 0.045  # how much that share differs between contacts
CERTAIN = 6.0  # standard deviations, least rise of the top
AROUND = 0.5  # share of the width of a convex part that is looked at on all sides of it at first
ENOUGH = 1500  # bins from which a plane or a quadratic is fitted
MOST_BINS = 620_000  # of all windows that are searched for faces in one frame: a press takes a twentieth of that


@dataclass(frozen=True, slots=True)
class Patch:
    """A contact in the bins of a surface: its mask, a score (h, w) that falls through 0 at its edge, and the score's noise."""

    surface: Surface
    mask: MaskArray
    score: Image
    sd: float


class Effort:
    """Bins that one frame may still cost, so that each frame is answered or refused in time."""

    def __init__(self) -> None:
        self.left = MOST_BINS

    def spend(self, bins: int) -> None:
        """Count a search of some bins for a face; raises IllConditioned where a frame has taken too many."""
        self.left -= bins
        if self.left < 0:
            raise IllConditioned(
                "curved places are spread over the whole of the frame, as steps and edges of a room are, and show no membrane with an"
                " object in it; look where the camera points, and leave out what is not the membrane (`mask_membrane`)"
            )


def flat_or_round(
    surface: Surface, box: Box, part: MaskArray, signal: Signal, threshold: float, raised: MaskArray, effort: Effort
) -> Patch:
    """Return the contact that a convex part, in a box of the surface, belongs to: the part, or where it is a rim, the flat face within."""
    # What the part holds or meets mostly lies near it, and the rest of the frame costs time.
    shape, corner = raised.shape, (box[0].start, box[1].start)
    everything = slice(0, shape[0]), slice(0, shape[1])
    window = bounds(part, math.ceil(4.0 * surface.sigma), AROUND, corner)
    near, bent = surface.part(window), placed(part, box, window, shape)
    inside = inner_half(hull(bent))
    if curvature_of(near, inside) >= threshold:
        return Patch(near, filled(bent), signal.curvature[window] - np.float32(threshold), signal.sd)
    effort.spend(near.smooth.size)
    whole = touching(bent | (_above(near, bent) > 0.0), bent)
    if whole[[0, -1]].any() or whole[:, [0, -1]].any():
        inside, window = placed(inside, window, everything, shape), everything
        effort.spend(surface.smooth.size)
        near, bent = surface, placed(part, box, everything, shape)
        whole = touching(bent | (_above(near, bent) > 0.0), bent)
    return _flat_face(near, whole, inside, raised[window])


def holds_summit(patch: Patch) -> bool:
    """Whether the highest bin of a patch and of its surroundings lies in the patch.

    An object lifts the membrane above its surroundings; a fold of a slack sheet falls to one side.
    """
    window = bounds(patch.mask, 1)
    mask, height = patch.mask[window], patch.surface.smooth[window]
    around = with_rim(mask) & patch.surface.trusted[window]
    return bool(height.max(where=mask, initial=-np.inf) >= height.max(where=around, initial=-np.inf))


def with_above_plane(surface: Surface, part: MaskArray, score: Image, effort: Effort) -> Patch:
    """Add all bins above the plane of the part that hang together with it, and fill holes; `score` is in units of its noise."""
    effort.spend(surface.smooth.size // 2)
    above = _above(surface, part)
    whole = touching(part | (above > 0.0), part)
    # In units of the noise both scores weigh alike where the border is drawn between bins.
    above /= np.float32(max(surface.smooth_sd, 1e-9))
    return Patch(surface, whole, np.maximum(score, above, out=above), 1.0)


def _some(part: MaskArray) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    at = np.flatnonzero(part)
    v, u = np.divmod(at[:: max(1, len(at) // ENOUGH)], part.shape[1])
    return v, u


def curvature_of(surface: Surface, part: MaskArray) -> float:
    """Return the mean curvature, 1/m, of a quadratic through the unsmoothed heights of a part.

    Smoothing would carry the bend at a rim into a face that is flat. Infinite where the part is too small for a fit.
    """
    v, u = _some(part & surface.valid)
    if len(u) < 12:
        return math.inf
    x, y = (u - u.mean()) * surface.pitch, (v - v.mean()) * surface.pitch
    size = float(np.sqrt((x * x + y * y).mean()))
    x, y = x / size, y / size
    design = np.stack([np.ones(len(u)), x, y, x * x, x * y, y * y])
    try:
        solution = np.linalg.solve(design @ design.T, design @ surface.height[v, u].astype(np.float64))
    except np.linalg.LinAlgError:
        return math.inf
    return -float(solution[3] + solution[5]) / size**2


def _above(surface: Surface, part: MaskArray) -> Image:
    """Return the height, m, of every bin above the plane through the bins of `part`."""
    v, u = _some(part)
    z = surface.smooth[v, u].astype(np.float64)
    mean_u, mean_v, mean_z = float(u.mean()), float(v.mean()), float(z.mean())
    du, dv = u - mean_u, v - mean_v
    uu, uv, vv = float(du @ du) + 1e-9, float(du @ dv), float(dv @ dv) + 1e-9
    along_u, along_v = float(du @ z), float(dv @ z)
    slope_u, slope_v = (c / (uu * vv - uv * uv) for c in (vv * along_u - uv * along_v, uu * along_v - uv * along_u))
    rows, columns = (np.arange(n, dtype=np.float32) for n in part.shape)
    level = np.float32(slope_v) * (rows - np.float32(mean_v)) + np.float32(mean_z)
    across = np.float32(slope_u) * (columns - np.float32(mean_u))
    return np.asarray(surface.smooth - (level[:, None] + across), dtype=np.float32)


def _flat_face(surface: Surface, whole: MaskArray, inside: MaskArray, raised: MaskArray) -> Patch:
    """Return the flat face that `inside` is part of, up to its rim.

    At a kink the smoothed height has dropped by just sigma^2 times its Laplacian, for any change of slope and any
    sigma, so that the height sharpened by this term crosses the plane of the face at the rim itself.
    """
    s = surface.sigma
    sd = surface.noise_after((0, 0, 1.0), (2, 0, -s * s), (0, 2, -s * s))
    score = _above(surface, inside) - np.float32(s * s) * laplacian(surface.height, s) + np.float32(1.5 * sd)
    return Patch(surface, touching(widened(whole, 2.0 * s) & raised & (score > 0.0), inside), score, sd)


def highest(surface: Surface, plane: float, noise: Callable[[], float]) -> list[Patch]:
    """Return what stands within a tenth of the highest place, where curvature says nothing; none if it may be noise.

    A membrane in tension has no summit off contact, so the summit at least is in contact. None either where the top
    reaches the edge of what is seen, because the summit may be beyond. `noise` gives the standard deviation of a height, m;
    it costs most of all here, and is asked last.
    """
    rise = surface.smooth - np.float32(plane)
    seen = np.where(surface.trusted, rise, np.float32(0))
    peak = float(seen.max(initial=0.0))
    if peak <= 0.1 * surface.sigma * surface.pitch:
        return []
    top = float(np.median(seen[seen > SHARE * peak]))
    at = np.zeros(rise.shape, dtype=bool)
    at[np.unravel_index(int(seen.argmax()), at.shape)] = True
    score = rise - np.float32(SHARE * top)
    mask = touching((score > 0.0) | at, at)
    if (mask & ~surface.trusted).any() or peak <= CERTAIN * (sd := noise()):
        return []
    return [Patch(surface, mask, score, float(np.hypot(sd, SHARE_SD * top)))]
