"""What the process of an arm checks in every cycle: the limits of the cell, measured rather than commanded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stretch_bt.hardware.past_limits import outside_limits, past_limit
from stretch_bt.hardware.slack import SLACK, most_measured
from stretch_bt.hardware.ur.force_filter import HandForce
from stretch_bt.hardware.ur.messages import ControllerSettings, Six

__all__ = ["MeasuredState", "beyond", "plausible", "safety_stop"]

#: bounds that no controller exceeds: modes, safety bits and joint angles, rad
_MODES, _BITS, _TURNED = range(-1, 12), 1 << 12, 7.0

#: bits of `safety_status_bits`, the first one that is set says the most
_SAFETY = (
    (7, "emergency stop: release the button, switch power and brakes on at the pendant, then start a new run"),
    (
        6,
        "emergency stop of the robot: release the button, switch power and brakes on at the pendant, then start a new run",
    ),
    (5, "emergency stop of the system: end it, switch power and brakes on at the pendant, then start a new run"),
    (9, "fault of the safety system: look at the pendant; the controller has to be restarted"),
    (8, "violation of the safety configuration: look at the pendant, then start a new run"),
    (
        2,
        "protective stop: look for its cause, move the hand clear if need be, wait 5 s, "
        "unlock it at the pendant, then start a new run",
    ),
    (4, "safeguard stop: close the safeguard, then start a new run"),
    (3, "recovery mode: move the arm back inside its limits at the pendant, then start a new run"),
    (10, "stopped for safety: look at the pendant, then start a new run"),
)


@dataclass(frozen=True, slots=True)
class MeasuredState:
    """What a controller sent in one package.

    Six joint angles, rad, pose and velocity of the tool and the wrench on it, all in the base, SI.
    """

    time: float
    q: Six
    tool: Six
    speed: Six
    wrench: Six
    mode: int
    #: whether it runs a program
    program: bool
    safety_bits: int


def safety_stop(bits: int) -> str | None:
    """Return what the safety bits of a controller say of a stop, and what to do; None while it is well."""
    return next((text for bit, text in _SAFETY if bits >> bit & 1), None)


def plausible(measured: MeasuredState) -> bool:
    """Whether a controller may have sent this: a broken stream is read by the client all the same."""
    return (
        measured.mode in _MODES
        and measured.safety_bits < _BITS
        and all(map(math.isfinite, (measured.time, *measured.tool, *measured.speed, *measured.wrench)))
        and all(abs(angle) < _TURNED for angle in measured.q)
    )


def beyond(
    settings: ControllerSettings, place: Sequence[float], speed: float, force: HandForce, contact_height: float | None
) -> str | None:
    """Return which limit of the cell is passed, or None.

    Parameters
    ----------
    settings
        Settings with the limits.
    place
        (3,) place of the hand in the world, m.
    speed
        Speed of the hand, m/s.
    force
        Force on the hand.
    contact_height
        World height of first contact, m, once it is known.
    """
    for name, value, (least, most) in zip(
        ("x", "y", "height"), place, (settings.x, settings.y, settings.height), strict=True
    ):
        if not least - SLACK <= value <= most + SLACK:
            return outside_limits(name, value, least, most)
    if contact_height is not None and contact_height - place[2] > settings.depth + SLACK:
        return past_limit("depth", contact_height - place[2], settings.depth, "Length")
    if (fast := _too_fast(settings, place[2], speed)) is not None:
        return fast
    if not force.average <= settings.force:
        return past_limit("force", force.average, settings.force, "Force")
    if not force.sample <= settings.sample_force:
        return f"force {force.sample:.1f} N in one sample is past {settings.sample_force:g} N, which no noise reaches"
    return None


def _too_fast(settings: ControllerSettings, height: float, speed: float) -> str | None:
    """Return that the hand is faster than it may be at its height, m; else None."""
    below, most, where = settings.contact_below, settings.speed, ""
    if below is not None and height < below:
        most, where = settings.contact_speed, f" below a height of {1e3 * below:g} mm"
    if speed <= most_measured(most):
        return None
    return past_limit("speed", speed, most, "Speed") + where
