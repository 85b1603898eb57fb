"""Which kinds of device measure a quantity that a scene knows."""

from __future__ import annotations

from collections.abc import Collection

__all__ = ["measured_by"]

_CAMERA = frozenset({"DepthCamera"})
_OTHERS = {
    "stretch": frozenset({"Gripper"}),
    "depth": frozenset({"Arm"}),
    "stiffness": frozenset({"DepthCamera", "ForceSensor"}),
}


def measured_by(quantity: str, kinds: Collection[str]) -> frozenset[str]:
    """Return the kinds of device through which a quantity of a scene is measured in a cell that has these kinds.

    The force sensor measures a force, or the arm where there is none; the camera measures what an object looks like.
    """
    if quantity == "force":
        return frozenset({"ForceSensor" if "ForceSensor" in kinds else "Arm"})
    return _OTHERS.get(quantity, _CAMERA)
