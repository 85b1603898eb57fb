"""The quantities that every scene knows, or an object that is shipped, and which kinds of device measure one."""

from __future__ import annotations

from collections.abc import Collection

__all__ = ["QUANTITIES", "measured_by"]

#: the kind of each, as in `stretch_bt.units.KINDS`; own objects and scenes know more
QUANTITIES = {
    "force": "Force",
    "stiffness": "Stiffness",
    "yield_stress": "Pressure",
    **dict.fromkeys(("deflection", "stretch", "depth", "height", "contact_height"), "Length"),
    **dict.fromkeys(("length", "width", "radius", "side", "span", "radius_1", "radius_2", "radius_3"), "Length"),
}

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
