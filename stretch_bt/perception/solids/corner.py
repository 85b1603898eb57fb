"""The edge of a flat top under a membrane: where its side stands and how high its top is, however stiff the membrane is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.bend import Bend, fit_bend
from stretch_bt.perception.solids.profile import HeightProfile
from stretch_bt.perception.solids.result import Dimension

__all__ = ["Corner", "fit_corner"]

Array = npt.NDArray[np.float64]

ROUNDS = 2  # until the line of the force has settled
FLATTEST = 0.15  # slope of the near side over the width that is fitted, at most: else it is no top
SIDE_SD, TOP_SD = (
    0.15e-3,
    0.08e-3,
)  # m, standard deviations of a side and a top beside the fit's own (benchmarks/conformity.py)


@dataclass(frozen=True, slots=True)
class Corner:
    """The side and the height of an edge, m, and how far each moves with the radius of its fillet.

    `lean`, rad, is how far the force of the edge leans outwards.
    """

    side: Dimension
    top: Dimension
    lean: float

    @property
    def side_share(self) -> float:
        """Change of the side over the change of the fillet's radius."""
        return 1.0 - math.sin(self.lean)

    @property
    def top_share(self) -> float:
        """Change of the top over the change of the fillet's radius."""
        return 1.0 - math.cos(self.lean)


def fit_corner(profile: HeightProfile, start: float, fillet: float, *, reach: float) -> Corner:
    """Fit the bend of a profile over an edge near a place, m, whose fillet has a radius, m.

    An edge holds a membrane by a force that halves the angle between the straight parts to either side. One that resists bending
    touches the fillet where that force does, along a line, and passes from one straight part to the other alike on both sides; one
    that does not lies on the fillet. Either way the force goes through the middle of the fillet, the straight parts meet on its line,
    and how far above the membrane they do is seen. The bend is fitted in axes along the force and across it, in which its slopes are
    gentle; its near side is curved where the membrane spans the top as a saddle.

    Raises
    ------
    IllConditioned
        As `fit_bend`, or the near side is no flat top.
    """
    bend = fit_bend(profile, start, reach=reach)
    if abs(bend.near) > FLATTEST:
        raise IllConditioned("the membrane beside the edge is no flat top's; press nearer to the middle of the object")
    place, height, lean = bend.place, bend.height, _lean(bend)
    for _ in range(ROUNDS):
        c, s = math.cos(lean), math.sin(lean)
        bend = fit_bend(_turned(profile, place, height, lean), 0.0, reach=reach, curved=True)
        place, height = place + c * bend.place + s * bend.height, height - s * bend.place + c * bend.height
        lean += _lean(bend)
    above, s, c = bend.change * bend.length / 2, math.sin(lean), math.cos(lean)
    out, down = fillet - (fillet + above) * s, fillet - (fillet + above) * c
    side_sd = math.hypot(bend.sd * c, bend.change * bend.length_sd / 2 * s, SIDE_SD)
    top_sd = math.hypot(bend.height_sd, bend.sd * s, TOP_SD)
    return Corner(
        Dimension(place + out, side_sd, {"membrane": out}),
        Dimension(height + down, top_sd, {"membrane": down}),
        lean,
    )


def _lean(bend: Bend) -> float:
    return -(math.atan(bend.near) + math.atan(bend.far)) / 2


def _turned(profile: HeightProfile, place: float, height: float, lean: float) -> HeightProfile:
    """Return a profile in axes whose second one leans outwards, rad, from a place and a height, m."""
    c, s = math.cos(lean), math.sin(lean)
    u, w = profile.at - place, profile.height - height
    along, up = c * u - s * w, s * u + c * w
    order = np.argsort(along)
    return HeightProfile(along[order], up[order], profile.count[order], profile.noise)
