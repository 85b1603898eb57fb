"""The shape of points: each fit that there is, and the choice between them by evidence."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.perception.robust import TUKEY
from stretch_bt.perception.shapes.cone import cone_of, settle_cone
from stretch_bt.perception.shapes.cylinder import cylinder_of, settle_cylinder
from stretch_bt.perception.shapes.plane import plane_of, settle_plane
from stretch_bt.perception.shapes.robust_fit import Settled
from stretch_bt.perception.shapes.sight import Noise, Sight, sighted
from stretch_bt.perception.shapes.sphere import settle_sphere, sphere_of
from stretch_bt.perception.types import Candidate, Cone, Cylinder, FloatArray, Plane, Shape, ShapeKind, Sphere

__all__ = ["MARGIN", "fit_shape"]

MARGIN = 3.0  # nats, odds of 20, that a shape must gain over a simpler one

Wanted = Literal["auto"] | ShapeKind


@dataclass(frozen=True, slots=True)
class _Fitter:
    """How a shape is fitted to a Sight, and how the result is put in the caller's frame; simpler shapes come first."""

    settle: Callable[[Sight], Settled[Any]]
    finish: Callable[[Any, Sight], Plane | Sphere | Cylinder | Cone]


FITTERS: dict[ShapeKind, _Fitter] = {
    "plane": _Fitter(settle_plane, plane_of),
    "sphere": _Fitter(settle_sphere, sphere_of),
    "cylinder": _Fitter(settle_cylinder, cylinder_of),
    "cone": _Fitter(settle_cone, cone_of),
}


@dataclass(frozen=True, slots=True)
class _Fitted:
    kind: ShapeKind
    settled: Settled[Any]
    fit: Plane | Sphere | Cylinder | Cone | None
    refused: str = ""


def fit_shape(
    points: FloatArray, *, rays: FloatArray | None = None, noise: Noise = None, shape: Wanted = "auto"
) -> Shape:
    """Fit a shape to points whose noise lies along the camera rays, or the one shape that explains them best.

    Parameters
    ----------
    points : (n, 3) float, m
    rays : (n, 3) float, unit, or None
    noise : float, m, SurfaceNoise or None
        As for `fit_sphere`.
    shape : "auto", "plane", "sphere", "cylinder" or "cone"
        "auto" compares all by Schwarz's criterion (Schwarz, Annals of Statistics, 1978): Tukey's loss, with the noise of
        the best fit, plus half the logarithm of the number of independent points for every parameter. Of those within
        three nats of the best, which may be one whose parameters are refused, the simplest that is not refused is taken.

    Returns
    -------
    Shape

    Raises
    ------
    IllConditioned
        The points do not determine the shape, or any shape, or the best one while no other is within three nats of it; the
        reasons are in the text.
    InvalidInput
        An array has the wrong shape, the noise is not a positive number, or there is no such shape.
    """
    if not isinstance(shape, str) or (shape != "auto" and shape not in FITTERS):
        raise InvalidInput(f"a shape is one of auto, {', '.join(FITTERS)}, got {shown(shape)[:80]}")
    sight = sighted(points, rays, noise, name="plane" if shape == "auto" else shape, least=4)
    kinds = list(FITTERS) if shape == "auto" else [shape]
    tried = [_tried(kind, sight) for kind in kinds]
    if not any(isinstance(t, _Fitted) and t.fit is not None for t in tried):
        raise IllConditioned("; ".join(f"{t.kind}: {t.refused}" if len(tried) > 1 else t.refused for t in tried))
    return _chosen(tried, sight)


def _tried(kind: ShapeKind, sight: Sight) -> _Fitted | Candidate:
    """Return a shape as far as it could be fitted: without the fit, if its parameters were refused."""
    try:
        settled = FITTERS[kind].settle(sight)
    except IllConditioned as error:
        return Candidate(kind, None, error.reason)
    try:
        return _Fitted(kind, settled, FITTERS[kind].finish(settled, sight))
    except IllConditioned as error:
        return _Fitted(kind, settled, None, error.reason)


def _chosen(tried: list[_Fitted | Candidate], sight: Sight) -> Shape:
    """Return the simplest of the shapes, in their order, that is within the margin of the best; refused ones count as well."""
    settled = [t for t in tried if isinstance(t, _Fitted)]
    best = min(settled, key=lambda f: f.settled.scale).settled
    scale = max(best.scale, sight.floor)
    area = min(best.area, best.agreeing)
    evidence = {f.kind: _evidence(f.settled, scale, area) for f in settled}
    top = max(evidence.values())
    chosen = next((f for f in settled if f.fit is not None and evidence[f.kind] >= top - MARGIN), None)
    if chosen is None:
        likely = next(f for f in settled if evidence[f.kind] == top)
        raise IllConditioned(
            f"a {likely.kind} explains the points best, but {likely.refused}; name the `shape` if it is known to be another"
        )
    assert chosen.fit is not None
    ranking = [t if isinstance(t, Candidate) else Candidate(t.kind, evidence[t.kind] - top, t.refused) for t in tried]
    ranking.sort(key=lambda c: math.inf if c.evidence is None else -c.evidence)
    return Shape(chosen.kind, chosen.fit, chosen.settled.scale * sight.size, tuple(ranking))


def _evidence(settled: Settled[Any], scale: float, area: float) -> float:
    """Return the logarithm, nats, of a shape's probability given the points, up to a constant."""
    u = np.minimum(np.abs(settled.residuals) / (TUKEY * scale), 1.0)
    loss = TUKEY**2 / 6.0 * float((1.0 - (1.0 - u * u) ** 3).sum())
    freedom: int = settled.surface.parameters
    return -loss / area - 0.5 * freedom * float(np.log(u.size / area))
