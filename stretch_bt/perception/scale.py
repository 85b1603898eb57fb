"""A frame at one kernel: its surface, the raised part of it, and the curvatures that distinguish contact from skirt."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.curvature import SurfaceDerivatives, along_axes, bending, spread
from stretch_bt.perception.lateral import Lateral
from stretch_bt.perception.regions import bounds, widened
from stretch_bt.perception.robust import quantile, sample
from stretch_bt.perception.surface import Surface
from stretch_bt.perception.tension import combine, tension_ratio
from stretch_bt.perception.types import MaskArray
from stretch_bt.units import Estimate

__all__ = ["SEED", "Ground", "Scale", "Signal", "either_scale", "ground_of", "mean_scale"]

Image = npt.NDArray[np.float32]

SEED = 6.0  # standard deviations that a contact must show somewhere
MOST_SPREAD, MOST_FREE = 3.0, 5.0  # of the noise that is expected: as the flat part shows it, and all of the membrane
GROW = 3.0  # and everywhere
# Share of all that is seen, below which the flat part is too small to show noise, as under a taut sheet. Then all of the membrane does, whose mean
# curvature is 0 but at bodies and clamps, unless the clearest of these stands out by so many expected deviations that noise does not matter.
FLAT, QUIET = 0.25, 100.0


@dataclass(frozen=True, slots=True)
class Signal:
    """A curvature, 1/m, in bins, its noise, and the least that counts."""

    curvature: Image
    sd: float
    least: float

    @classmethod
    def of(cls, curvature: Image, ground: Ground, expected: float, *, balanced: bool = False) -> Signal:
        """Take a curvature with the noise that is expected of it, or that the flat part shows where it is more.

        Where it is very much more, the flat part is small and bent at its ends, and that is not noise. A `balanced` one is 0 where tensions
        alone act.
        """
        trusted, most = ground.surface.trusted, MOST_SPREAD
        shown = trusted & ~ground.raised
        clearest = float(np.max(curvature, where=ground.raised, initial=0.0))
        if balanced and np.count_nonzero(shown) < FLAT * np.count_nonzero(trusted) and clearest < QUIET * expected:
            shown, most = trusted, MOST_FREE
        sd = min(spread(curvature, shown, expected), most * expected)
        # A radius beyond the width of the view is a plane that is not quite flat.
        return cls(curvature, sd, max(GROW * sd, 1.0 / ground.surface.view))


@dataclass(frozen=True, slots=True)
class Ground:
    """The whole frame at one kernel, the height of its undeformed membrane, and the part of it that is raised."""

    kernel: float
    whole: Surface
    plane: float
    least_rise: float
    surface: Surface
    raised: MaskArray


@dataclass(frozen=True, slots=True)
class Scale:
    """The raised part of a frame at one kernel with its signals, and the ratio of the tensions that was used."""

    ground: Ground
    signals: tuple[Signal, ...]
    ratio: Estimate | None

    @property
    def clearness(self) -> float:
        """How many standard deviations the clearest signal stands out where the membrane is raised."""
        raised = self.ground.raised
        return max(float(np.max(s.curvature, where=raised, initial=0.0)) / max(s.sd, 1e-12) for s in self.signals)


def ground_of(kernel: float, whole: Surface) -> Ground:
    """Return a whole surface at a kernel, m, with its undeformed height and its raised part."""
    plane, least = _plane(whole), _least_rise(whole)
    raised = whole.smooth - np.float32(plane) > least
    # What is flat says nothing about curvature, and derivatives cost most.
    window = bounds(raised, math.ceil(4.0 * whole.sigma))
    return Ground(kernel, whole, plane, least, whole.part(window), raised[window])


def mean_scale(ground: Ground, moves: Lateral, expected: Estimate, before: Estimate | None) -> Scale:
    """Return a frame at one kernel with its mean curvature, weighted by the ratio of the tensions.

    `before` is the ratio that another kernel found, if it did.
    """
    bent = bending(ground.surface, moves)
    found = _ratio(ground, bent, expected, before)
    ratio = found or before or expected
    return Scale(ground, (_weighted(ground, bent, ratio.value),), found or before)


def _ratio(ground: Ground, bent: SurfaceDerivatives, expected: Estimate, before: Estimate | None) -> Estimate | None:
    """Return the ratio of the tensions, from the raised part that is not in contact by the ratio so far; None if unseen."""
    surface, found = ground.surface, before
    for _ in range(1 if before else 3):
        last = (found or expected).value
        signal = _weighted(ground, bent, last)
        strong = ground.raised & (signal.curvature > SEED * signal.sd)
        off = np.flatnonzero(ground.raised & surface.trusted & ~widened(strong, 2.0 * surface.sigma))
        try:
            found = combine(expected, tension_ratio(bent.xx.reshape(-1)[off], bent.yy.reshape(-1)[off]))
        except IllConditioned:
            break
        if 0.7 < found / last < 1.4:
            break
    return found


def _weighted(ground: Ground, bent: SurfaceDerivatives, ratio: float) -> Signal:
    """Return the mean curvature weighted by the tensions.

    (h_xx + k h_yy) / ((1 + h_x^2 + k (1 + h_y^2)) sqrt(1 + h_x^2 + h_y^2)), its sign turned, is 1/R on any sphere, and 0
    where only tensions act.
    """
    from stretch_bt.perception.surface_kernel import fill_weighted

    surface, curvature = ground.surface, np.empty_like(bent.x)
    fill_weighted(bent.x, bent.y, bent.xx, bent.yy, surface.trusted, ratio, curvature)
    expected = surface.noise_after((2, 0, 1.0), (0, 2, round(ratio, 1))) / (1.0 + ratio) / surface.pitch**2
    return Signal.of(curvature, ground, expected, balanced=True)


def either_scale(ground: Ground, moves: Lateral) -> Scale:
    """Return a frame at one kernel with its curvatures along both axes."""
    along = along_axes(ground.surface, bending(ground.surface, moves))
    expected = ground.surface.noise_after((2, 0, 1.0)) / ground.surface.pitch**2
    signals = tuple(Signal.of(curvature, ground, expected) for curvature in along)
    return Scale(ground, signals, None)


def _plane(surface: Surface) -> float:
    """Return the height of the undeformed membrane above the surface's level, m."""
    if surface.towards > 0:
        return -surface.level
    seen = sample(surface.smooth, surface.trusted & surface.valid)
    # In the camera frame the membrane's distance is unknown; its lowest part is taken to be undeformed.
    return quantile(seen, 0.05) + 1.645 * surface.smooth_sd if seen.size else 0.0


def _least_rise(surface: Surface) -> float:
    """Return the rise, m, from which a bin counts as deformed."""
    return max(3.0 * surface.smooth_sd, 0.01 * surface.sigma * surface.pitch)
