"""One sphere from two fits of the same."""

from __future__ import annotations

import math

from stretch_bt.arguments import check_kind
from stretch_bt.errors import InvalidInput
from stretch_bt.perception.types import Sphere

__all__ = ["pooled_sphere"]


def pooled_sphere(before: Sphere, now: Sphere) -> Sphere:
    """Return the sphere whose curvature is the mean of two independent fits in the membrane frame, weighted by their variances.

    Its top, the highest place along z, is the one of `now`.

    Where the two differ by more than their standard deviations say, the mean's grows by as much (Birge, Physical Review 40,
    207, 1932). `before` counts nothing where its curvature has the other sign.
    """
    for what, given in (("before", before), ("now", now)):
        check_kind(what, given, Sphere, "`fit_sphere` makes one")
    for what, given in (("before", before), ("now", now)):
        if not given.curvature_sd > 0.0:
            raise InvalidInput(
                f"{what}: a curvature needs a standard deviation above 0 to be weighted, got {given.curvature_sd}"
            )
    if before.curvature * now.curvature <= 0:
        return now
    weights = before.curvature_sd**-2, now.curvature_sd**-2
    curvature = (weights[0] * before.curvature + weights[1] * now.curvature) / sum(weights)
    apart = abs(before.curvature - now.curvature) / math.hypot(before.curvature_sd, now.curvature_sd)
    curvature_sd = max(1.0, apart) / math.sqrt(sum(weights))
    radius = 1 / abs(curvature)
    center, center_sd = now.center.copy(), now.center_sd.copy()
    center[2] += math.copysign(1.0, curvature) * (now.radius - radius)
    radius_sd = curvature_sd * radius**2
    center_sd[2] = math.hypot(math.sqrt(max(center_sd[2] ** 2 - now.radius_sd**2, 0.0)), radius_sd)
    return Sphere(radius, radius_sd, center, center_sd, curvature, curvature_sd)
