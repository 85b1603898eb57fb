"""Where the sheet needs small elements under a rectangular top with rounded edges."""

from __future__ import annotations

import numpy as np

from stretch_bt.simulation.membrane.indenters.base import Array, Zone, flatness, spacing

__all__ = ["edge_zones"]


def edge_zones(
    halves: tuple[float, float], edge: float, rotation: Array, gauge: float, *, turned: bool
) -> tuple[list[Zone], list[Zone]]:
    """Return zones along x and y for a face of these half extents within an edge of this radius, m, after a rotation (3, 3).

    Strips along the edges, or where they may be `turned`, so that none runs along an axis, all in between. A face spreads
    the force along its edges, and the sheet leaves it near its sides. The less of a face there is, the closer to its
    middle the sheet leaves, and the more of the force bears on the fillet: without any face it is a ball, or a round bar,
    and has the elements of one.
    """
    face, length = flatness(min(halves), edge), spacing(edge, gauge)
    reach, size = (3 + 1.5 * face) * length, (1 + 2 * face**2) * length
    corners = np.array([[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]]) * [*(h + face * edge for h in halves), 0.0]
    places = corners @ rotation.T
    return _zones(places[:, 0], reach, size, turned), _zones(places[:, 1], reach, size, turned)


def _zones(corners: Array, reach: float, size: float, turned: bool) -> list[Zone]:
    places = np.unique(np.round(corners, 9)).tolist()
    if turned and len(places) > 2:
        return [Zone(places[0] - reach, places[-1] + reach, size)]
    return [Zone(place - reach, place + reach, size) for place in places]
