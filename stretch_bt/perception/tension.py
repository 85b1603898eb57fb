"""The ratio of the membrane's tensions along j and i, from the surface itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_unmasked
from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.perception.robust import MAD_TO_SD, TUKEY
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Estimate

__all__ = ["LEAST_PULL", "PRIOR", "check_stretch", "combine", "expected_ratio", "tension_ratio"]

Array = npt.NDArray[np.floating[Any]]

PRIOR = (2.0, 1.0)  # mean and deviation of ln(T_j / T_i) of any membrane: 2.7 to 20 in two cases of three
# The same of a membrane 90 mm wide and 100 mm long that is pulled by a stretch in m, less than 5 mm excepted; a line
# through the ratios that this module finds on noise-free presses of the sheet solver at 5, 30 and 60 mm.
AT_REST, PER_METRE, PULLED_SD, LEAST_PULL = 2.47, 10.7, 0.3, 5e-3
ENOUGH = 600  # places that are used; more would mostly repeat the noise of their neighbours
SIGNIFICANT = 4.0  # standard deviations, least excess of the bending over noise alone
ROUNDS, CLOSE = 40, 1e-3  # rounds of weights, and rad that the line may still turn
WIDEST = 0.15  # m, stretch beyond which a number is taken to be in another unit
LEAST, MOST = 0.2, 40.0  # ratios of a sheet that is pulled along j and free at its sides


def tension_ratio(along_i: Array, along_j: Array, *, share: float = 1.0 / 3.0) -> Estimate:
    """Return T_j / T_i from second derivatives of the height off contact, and its standard deviation.

    Parameters
    ----------
    along_i, along_j : (n,) float, 1/m
        h_xx and h_yy at places where nothing touches the membrane; a minority may be in contact.
    share : float
        Correlation of their noise; after one isotropic filter it is 1/3.

    Returns
    -------
    Estimate
        Equilibrium there is T_i h_xx + T_j h_yy = 0 (the shallow membrane), so both derivatives lie on a line through 0.
        Both are noisy, so its slope comes from total least squares in the metric of the noise, with Tukey's weights. The
        deviation counts every place: neighbours under one kernel share their noise, but its second derivatives cancel
        over a few of them.

    Raises
    ------
    IllConditioned
        There are too few places, or the line does not stand out from the noise.
    """
    from stretch_bt.perception.tension_kernel import settle_angle

    if not (is_number(share) and -1.0 < share < 1.0):
        raise InvalidInput(f"share is a correlation between -1 and 1, got {shown(share)[:80]}")
    for what, given in (("along_i", along_i), ("along_j", along_j)):
        check_unmasked(f"{what} is", given, "the values that are known")
        if (
            not isinstance(given, np.ndarray)
            or given.shape != np.shape(along_i)
            or given.ndim != 1
            or given.dtype.kind != "f"
        ):
            raise InvalidInput(f"{what} are (n,) floats, 1/m, as many as along_i, got {shown(given)[:80]}")
    every = max(1, len(along_i) // ENOUGH)
    pairs = np.stack([along_i[::every], along_j[::every]]).astype(np.float64)
    if pairs.shape[1] < 30:
        raise IllConditioned(
            f"a tension ratio needs thirty places off contact, there are {pairs.shape[1]}; keep more of the membrane in view"
        )
    # Sum and difference are independent in noise; scaled by it, noise is a circle.
    scale = np.array([[1.0 / math.sqrt(1.0 + share)], [1.0 / math.sqrt(1.0 - share)]])
    turned = np.stack([pairs[0] + pairs[1], pairs[0] - pairs[1]]) * scale
    # In contact both are negative, off contact they differ in sign; Tukey's weights need that start where many touch.
    weights = np.asarray(pairs[0] * pairs[1] < 0.0, dtype=np.float64)
    angle, sd = settle_angle(turned[0], turned[1], weights, MAD_TO_SD, TUKEY, CLOSE, ROUNDS)
    along = -math.sin(angle) * turned[0] + math.cos(angle) * turned[1]
    signal = float(weights @ (along * along)) - sd * sd * float(weights.sum())
    if not signal > SIGNIFICANT * sd * sd * math.sqrt(2.0 * float(weights.sum())):
        raise IllConditioned(
            "off contact the membrane is not bent beyond the noise, so that it does not show the ratio of its tensions; press deeper, or"
            " average more frames"
        )
    return _ratio_of(angle, sd / math.sqrt(signal), scale)


def _ratio_of(angle: float, error: float, scale: Array) -> Estimate:
    """Return the ratio that an angle in scaled sums and differences stands for."""

    def ratio(at: float) -> float:
        sums, differences = math.cos(at) * float(scale[0, 0]), math.sin(at) * float(scale[1, 0])
        first, second = sums + differences, sums - differences
        return math.inf if first == 0.0 else second / first

    found = ratio(angle)
    if not LEAST <= found <= MOST:
        raise IllConditioned(
            f"off contact the membrane is bent as no membrane in tension is (ratio {found:.3g}, not {LEAST:g} to {MOST:g}); look whether"
            " it is slack, or touches something else"
        )
    step = 1e-4
    return Estimate(found, abs(ratio(angle + step) - ratio(angle - step)) / (2.0 * step) * error)


def check_stretch(stretch: float | None) -> None:
    """Raise InvalidInput unless a stretch is unknown, or a length in m that a membrane of some 0.1 m can have."""
    if stretch is not None and not (is_number(stretch) and 0.0 <= stretch < WIDEST):
        raise InvalidInput(f"a stretch is from 0 to {WIDEST} m, got {shown(stretch)}")


def expected_ratio(stretch: float | None) -> Estimate:
    """Return the ratio to expect at a stretch, m, with its standard deviation; wide where it is unknown or small.

    Raises InvalidInput as `check_stretch`.
    """
    check_stretch(stretch)
    mean, sd = PRIOR
    if stretch is not None and stretch >= LEAST_PULL:
        mean, sd = AT_REST + PER_METRE * stretch, PULLED_SD
    return Estimate(math.exp(mean), math.exp(mean) * sd)


def combine(expected: Estimate, found: Estimate) -> Estimate:
    """Return both estimates of a ratio as one, weighted in the logarithm; `found` alone where they disagree."""
    a, b = math.log(expected.value), math.log(found.value)
    wa, wb = (expected.value / expected.sd) ** 2, (found.value / found.sd) ** 2
    if (a - b) ** 2 > 9.0 * (1.0 / wa + 1.0 / wb):
        return found
    value = math.exp((wa * a + wb * b) / (wa + wb))
    return Estimate(value, value / math.sqrt(wa + wb))
