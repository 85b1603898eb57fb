"""How far the force of a mesh is from that of an endlessly fine one: a law fitted to presses solved on finer meshes.

Against meshes three times finer, at random places, tilts, stretches and depths, the force of the default mesh is off by
0.1 to 0.3 % under spheres, 0.6 % under cones and 0.3 to 1.5 % under cylinders and cubes; it grows on coarser meshes, on a
slack sheet, and where few quadrature points touch; it is three times larger where a free edge or a clamp is next to the
contact. The law states about that much, so three times it covers nearly all.
"""

from __future__ import annotations

import math

__all__ = ["relative_error"]

_ROUND, _FLAT = 0.003, 0.008
_SLACK, _TAUT = 1.5, 0.02  # a slack sheet is this much worse, which fades over this strain
_PER_POINT = 0.15
_SHARP = 0.01
_WITH_FRICTION = 0.002


def relative_error(
    scale: float,
    strain: float,
    nodes: int,
    *,
    flat: bool,
    edge: float,
    sharp: bool,
    exact: bool,
    has_friction: bool = False,
) -> float:
    """Return the estimated error of the force over the force.

    Parameters
    ----------
    scale
        Length of the smallest elements over that of the default mesh.
    strain
        Nominal strain between the clamps.
    nodes
        Quadrature points in contact.
    flat, exact
        Whether the indenter has a face and rim, and whether the forces were made to balance exactly or corrected.
    edge
        1 where no edge of the sheet is near; 3 next to one, and 12 where the indenter's axis is about over it.
    sharp
        Whether a sheet with bending stiffness lies on a tip that is sharper than it is thick.
    has_friction
        Whether there is friction: the springs that points stick by, and the path, are then known to 0.2 %.
    """
    base = (_FLAT if flat else _ROUND) * (scale**2 if flat or scale < 1 else scale**1.7)
    base = base * edge + (_SHARP if sharp else 0.0)
    slack = 1 + _SLACK * math.exp(-strain / _TAUT)
    return (
        base * slack
        + _PER_POINT / max(nodes, 1)
        + (0.0 if exact else 0.005)
        + (_WITH_FRICTION if has_friction else 0.0)
    )
