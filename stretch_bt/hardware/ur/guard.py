"""What the process of an arm checks in every cycle: the limits of the cell, measured rather than commanded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stretch_bt.hardware.ur.settings import Settings

if TYPE_CHECKING:
    from rtde_receive import RTDEReceiveInterface

__all__ = ["beyond", "plausible", "safety_stop"]

#: how far past a limit a measured place may be, m, and a measured speed, m/s and as a part
_SLACK = 0.002
_SPEED_SLACK, _SPEED_PART = 0.02, 1.2
#: what no controller tells: modes, safety bits and joint angles, rad, beyond these
_MODES, _BITS, _TURNED = range(-1, 12), 1 << 12, 7.0

#: bits of `safety_status_bits`, the first one that is set tells the most
_SAFETY = (
    (7, "emergency stop: release the button, switch power and brakes on at the pendant, then acknowledge"),
    (6, "emergency stop of the robot: release the button, switch power and brakes on at the pendant, then acknowledge"),
    (5, "emergency stop of the system: end it, switch power and brakes on at the pendant, then acknowledge"),
    (9, "fault of the safety system: look at the pendant; the controller has to be restarted"),
    (8, "violation of the safety configuration: look at the pendant, then acknowledge"),
    (
        2,
        "protective stop: look for its cause, move the hand clear if need be, wait 5 s, then acknowledge, which unlocks it",
    ),
    (4, "safeguard stop: close the safeguard, then acknowledge"),
    (3, "recovery mode: move the arm back inside its limits at the pendant, then acknowledge"),
    (10, "stopped for safety: look at the pendant, then acknowledge"),
)


def safety_stop(bits: int) -> str | None:
    """Return what the safety bits of a controller tell of a stop, and what to do; None while it is well."""
    return next((text for bit, text in _SAFETY if bits >> bit & 1), None)


def plausible(receive: RTDEReceiveInterface) -> bool:
    """Whether a controller may be in the state that was received last: a broken stream is read by the client all the same."""
    place, speed, wrench = receive.getActualTCPPose(), receive.getActualTCPSpeed(), receive.getActualTCPForce()
    return (
        receive.getRobotMode() in _MODES
        and receive.getSafetyStatusBits() < _BITS
        and all(map(math.isfinite, (receive.getTimestamp(), *place, *speed, *wrench)))
        and all(abs(angle) < _TURNED for angle in receive.getActualQ())
    )


def beyond(
    settings: Settings, place: Sequence[float], speed: float, force: float, contact_height: float | None
) -> str | None:
    """Return which limit of the cell is passed, or None.

    Parameters
    ----------
    settings
        With the limits.
    place
        (3,) of the hand in the world, m.
    speed
        Of the hand, m/s.
    force
        On the hand, N.
    contact_height
        World height of first contact, m, once it is known.
    """
    for name, value, (least, most) in zip(
        ("x", "y", "height"), place, (settings.x, settings.y, settings.height), strict=True
    ):
        if not least - _SLACK <= value <= most + _SLACK:
            return (
                f"{name} {1e3 * value:.1f} mm is past the limits of the cell, {1e3 * least:g} mm to {1e3 * most:g} mm"
            )
    if contact_height is not None and contact_height - place[2] > settings.depth + _SLACK:
        depth = 1e3 * (contact_height - place[2])
        return f"depth {depth:.1f} mm is past the limit of the cell, at most {1e3 * settings.depth:g} mm"
    if speed > _SPEED_PART * settings.speed + _SPEED_SLACK:
        return f"speed {1e3 * speed:.0f} mm/s is past the limit of the cell, at most {1e3 * settings.speed:g} mm/s"
    if not force <= settings.force or not math.isfinite(force):
        return f"force {force:.1f} N is past the limit of the cell, at most {settings.force:g} N"
    return None
