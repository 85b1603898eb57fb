"""How round a closed outline is: 4 pi area / perimeter^2, which is 1 for a disc and pi / 4 for a square.

The area is harmless, the perimeter is not: it grows with every wiggle of the boundary, so each method is a way to say
which wiggles belong to the object.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.frames import as_numbers
from stretch_bt.perception.outlines.pixel_chain import chain_of
from stretch_bt.perception.outlines.polyline import Curve, area_of, even, lengthened, perimeter_of, redrawn, smoothed
from stretch_bt.units import Estimate

__all__ = ["METHODS", "Method", "Roundness", "circularity", "contour_of", "roundness"]

Method = Literal["contour", "pixel_chain", "low_pass"]

HARMONICS = 8
CORNERS = 16  # an outline of fewer vertices is a polygon, and each of them one of its corners
REPLICATES = 24  # of the boundary's own noise, for the standard deviation


@dataclass(frozen=True, slots=True)
class Roundness:
    """A circularity with its standard deviation, and the method that gave it: methods differ by 10 % and more."""

    circularity: float
    circularity_sd: float
    method: str


def circularity(outline: npt.NDArray[Any], *, method: Method = "contour") -> float:
    """Return 4 pi area / perimeter^2 of a closed outline, an Estimate with its standard deviation.

    Parameters
    ----------
    outline : (n, 2) float or int
        Vertices in order, of any unit; the last joins the first. Fewer than 16 are the corners of a polygon, more are
        samples of a boundary with noise.
    method : "contour", "pixel_chain" or "low_pass"
        "contour": the perimeter of the outline, smoothed as far as its own noise asks for and no further at corners.
        "pixel_chain": the perimeter of the chain of pixels which a tracer returns, as much of the literature has it; a perfect
        disc scores 0.89 to 0.90. An outline that is no such chain is drawn on a grid of its spacing and traced.
        "low_pass": the perimeter of its first 8 Fourier harmonics; a perfect square scores 0.84.

    Returns
    -------
    Estimate
        The standard deviation comes from the noise which the boundary itself shows, and from the noise that smoothing leaves. The loss of every
        outline of a sampled object, as at sharp corners, is not in it: a square of 60 samples a side comes out up to 0.03 high.

    Raises
    ------
    InvalidInput
        The vertices are no finite (n, 2) array of real numbers, or there is no such method.
    IllConditioned
        The outline encloses no area.
    """
    found = roundness(outline, method=method)
    return Estimate(found.circularity, found.circularity_sd)


def roundness(outline: npt.NDArray[Any], *, method: Method = "contour") -> Roundness:
    """Do as `circularity`, and return the method with the numbers."""
    if not isinstance(method, str) or method not in METHODS:
        raise InvalidInput(f"method is one of {', '.join(METHODS)}, got {shown(method)[:80]}")
    curve = contour_of(outline)
    value = _ratio(METHODS[method](curve))
    if len(curve) < CORNERS:
        return Roundness(value, 0.0, method)
    sampled = even(curve)
    others = [_ratio(METHODS[method](replica)) for replica in redrawn(sampled, REPLICATES)]
    left = 2.0 * value * lengthened(sampled) if method == "contour" else 0.0
    return Roundness(value, math.hypot(float(np.std(others, ddof=1)), left), method)


def contour_of(outline: npt.NDArray[Any]) -> Curve:
    """Return an outline as complex numbers x + iy about its middle, without repeated vertices; raises as `circularity`."""
    vertices = as_numbers("an outline is", outline, "the vertices that are known")
    if vertices.ndim != 2 or vertices.shape[1] != 2 or vertices.dtype.kind not in "fiu":
        raise InvalidInput(f"an outline has shape (n, 2) and real numbers, got {vertices.dtype} {vertices.shape}")
    if not np.isfinite(vertices).all():
        raise InvalidInput("an outline has finite vertices; leave out those that are not known")
    if len(vertices) < 3:
        raise IllConditioned(f"an outline has at least three vertices, got {len(vertices)}; give the whole outline")
    known = vertices.astype(np.float64)
    centred = known - known.min(axis=0) - np.ptp(known, axis=0) / 2
    curve: Curve = centred[:, 0] + 1j * centred[:, 1]
    curve = curve[curve != np.roll(curve, 1)]
    scale = float(np.abs(curve).max(initial=0.0))
    if len(curve) < 3 or area_of(curve) <= 1e-9 * scale * scale:
        raise IllConditioned(
            "the outline encloses no area: its vertices lie on one line; press deeper, so that an area touches"
        )
    return curve


def _ratio(curve: Curve) -> float:
    return 4.0 * np.pi * area_of(curve) / perimeter_of(curve) ** 2


def _without_noise(curve: Curve) -> Curve:
    return curve if len(curve) < CORNERS else smoothed(even(curve))


def _low_pass(curve: Curve) -> Curve:
    """Return the curve of the first Fourier coefficients (Kuhl and Giardina, 1982), sampled finely."""
    at = even(curve) if len(curve) >= CORNERS else even(curve, perimeter_of(curve) / 1024)
    found = np.fft.fft(at) / len(at)
    kept = min(HARMONICS, (len(at) - 1) // 2)
    full = np.zeros(1024, dtype=np.complex128)
    full[: kept + 1] = found[: kept + 1]
    full[-kept:] = found[-kept:]
    return np.asarray(np.fft.ifft(full) * full.size)


METHODS: dict[str, Callable[[Curve], Curve]] = {
    "contour": _without_noise,
    "pixel_chain": chain_of,
    "low_pass": _low_pass,
}
