"""Error of a mesh's force against an endlessly fine mesh's: a law fitted to presses solved on finer meshes.

The law states one standard deviation: over presses of a kind the root mean square of error over stated error is about 1.
`python -m benchmarks.membrane_errors` prints both for each kind, and the constants below are fitted to its presses.
"""

from __future__ import annotations

import math

__all__ = ["relative_error", "side_error"]

# relative errors of the force on the default mesh; under round tips over the root of the points in contact
_ROUND, _FLAT = 0.018, 0.001
_SLACK, _TAUT = 12.0, 0.02  # a slack sheet is this much worse, which fades over this strain
_PER_POINT, _PER_POINT_FLAT = 0.15, 0.8
_ADDED, _STRAINED = 0.3, 0.02  # residual of a first-order correction, as a part of it; more where it is large
_ADDED_ACROSS = 0.2
_SLIPPING = 0.02
_RIM = 0.002  # where the indenter stands on its rim
_OVERHANG, _SLID = 0.1, 45.0  # over the part of the depth that a tip stands out; the latter times that correction
_SHARP = 0.01
_SETTLED, _SETTLED_SHALLOW = 0.004, 0.015
_WITH_FRICTION = 0.002
_SIDE_ADDED, _SIDE_ADDED_FLAT, _SIDE = 1.5, 0.3, 0.03
#: over the part of the depth that a tip stands out: elements shift the contact to one side of the tip
_SIDE_OVERHANG = 0.5
_SIDE_FLAT, _SIDE_TILTED = 0.012, 0.03  # how far a rim, and one that the indenter stands on, spoils the force across


def relative_error(
    scale: float,
    strain: float,
    nodes: int,
    *,
    face: float,
    ridge: float = 0.0,
    edge: float,
    sharp: bool,
    exact: bool,
    shallow: bool = False,
    tilted: bool = False,
    added: float = 0.0,
    across: float = 0.0,
    sideways: float = 0.0,
    overhang: float = 0.0,
    has_friction: bool = False,
) -> float:
    """Return the standard deviation of the force's discretisation error over the force.

    Parameters
    ----------
    scale
        Length of the smallest elements over the default mesh's.
    strain
        Nominal strain between the clamps.
    nodes
        Quadrature points in contact.
    face
        How far the indenter is one with a face and rim, 1, or a round tip, 0.
    ridge
        How far it is longer than wide, 0 to 1: points along a ridge are off alike.
    exact
        Whether the forces were made to balance exactly or corrected.
    shallow
        Whether so little of the sheet touches that a result that is not exact is less certain.
    edge
        0 where no edge of the sheet is near; else its error of a taut sheet's force, over the force.
    sharp
        Whether a sheet with bending stiffness lies on a tip that is sharper than it is thick.
    tilted
        Whether the indenter is tilted: one with a rim then stands on it.
    added, across
        Correction to rigid contact along z and across, over the force.
    sideways
        Force across over the force along z: where the sheet is about to slip off, it is the larger one.
    overhang
        How far a tip stands out of the sheet, over the depth.
    has_friction
        Whether there is friction: the springs that points stick by, and the path, are then known to 0.2 %.
    """
    tip = _ROUND * (scale**1.7 if scale > 1 else scale**2) * math.sqrt((1 + ridge) / max(nodes, 1))
    base = tip + face * (_FLAT * scale**2 - tip)
    settled = (_SETTLED_SHALLOW if shallow else _SETTLED) * min(max(scale, 1.0), 2.0)
    return math.hypot(
        math.hypot(base, edge) * (1 + _SLACK * math.exp(-strain / _TAUT)),
        (_PER_POINT + face * (_PER_POINT_FLAT - _PER_POINT)) / max(nodes, 1),
        _ADDED * added * math.hypot(1.0, added / _STRAINED),
        _ADDED_ACROSS * across,
        _SLIPPING * sideways**2,
        _RIM * face if tilted else 0.0,
        overhang * math.hypot(_OVERHANG, _SLID * added),
        _SHARP if sharp else 0.0,
        0.0 if exact else settled,
        _WITH_FRICTION if has_friction else 0.0,
    )


def side_error(
    relative: float, sideways: float, added: tuple[float, float], *, face: float, tilted: bool, overhang: float
) -> float:
    """Return the standard deviation of the error of either force across, over the force along z.

    Parameters
    ----------
    relative
        Relative standard deviation of the force along z.
    sideways
        Force across over the force along z.
    added
        Correction to rigid contact across and along z, over the force along z.
    face
        How far the indenter is one with a face and rim, 1, or a round tip, 0.
    tilted
        Whether it is tilted: one with a rim then stands on it.
    overhang
        How far a tip stands out of the sheet, over the depth.
    """
    rim = face * (_SIDE_TILTED if tilted else _SIDE_FLAT)
    along = math.hypot((0.6 + 0.4 * face) * relative, _SIDE_ADDED_FLAT * face * added[1])
    return math.hypot(along, _SIDE * sideways, _SIDE_ADDED * added[0], rim, _SIDE_OVERHANG * overhang)
