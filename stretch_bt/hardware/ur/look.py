"""A look at a controller from outside, with nothing but its dashboard and its open ports."""

from __future__ import annotations

import itertools
import socket
from collections.abc import Iterator

from stretch_bt.frames import Pose
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.motion.path import PosePath
from stretch_bt.hardware.ur.dashboard import ask_dashboard
from stretch_bt.hardware.ur.options import UrOptions
from stretch_bt.hardware.ur.reach import Reach
from stretch_bt.hardware.ur.rtde import Rtde
from stretch_bt.hardware.ur.version import TOO_NEW, has_model, is_polyscope_x, major_minor

__all__ = ["look"]

_PORTS = {29999: "dashboard", 30003: "scripts", 30004: "RTDE"}
_WITHIN = 2.0
_FULL = 0.995
#: joint angles from which the corners are tried: elbow up, hand down, either side of the base
_STARTS = [(turn, -1.6, 1.8, -1.8, -1.5708, 0.0) for turn in (-3.14, -1.57, 0.0, 1.57)]


def look(name: str, options: UrOptions, limits: Limits) -> Iterator[Finding]:
    """Yield what ports and dashboard of a controller say, and whether the arm reaches the limits of the cell."""
    closed = [f"{port} ({what})" for port, what in _PORTS.items() if not _is_open(options.host, port)]
    detail = f"no answer at {options.host} port {', '.join(closed)}" if closed else f"{options.host} answers"
    fix = (
        "check cable, address, network of the pendant and its firewall; a newer PolyScope has to enable these services"
    )
    yield Finding(f"{name}: network", not closed, detail, fix if closed else "")
    if closed and is_polyscope_x(options.host):
        yield Finding(f"{name}: controller", False, TOO_NEW)
    if not closed:
        yield _controller(name, options)
        yield _slider(name, options)
    yield _corners(name, options, limits)


def _is_open(host: str, port: int) -> bool:
    try:
        socket.create_connection((host, port), timeout=_WITHIN).close()
    except OSError:
        return False
    return True


def _controller(name: str, options: UrOptions) -> Finding:
    check = f"{name}: controller"
    try:
        version, model, mode, safety = ask_dashboard(
            options.host, ["PolyscopeVersion", "get robot model", "robotmode", "safetymode"], _WITHIN
        )
    except OSError as error:
        return Finding(check, False, f"its dashboard does not answer ({error})", "restart the controller")
    number = major_minor(version)
    known = [model] if has_model(number) else []
    detail = "; ".join((version, *known, mode, safety))
    if not all("UR5" in name.upper() for name in known) or (number[0] >= 5) != options.model.endswith("e"):
        return Finding(check, False, detail, f"the cell file says {options.model}: write the `model` of this robot")
    if not mode.endswith("RUNNING"):
        return Finding(check, False, detail, "switch power and brakes on at the pendant")
    if not safety.endswith(("NORMAL", "REDUCED")):
        return Finding(check, False, detail, "look at the pendant for what stopped it, and end that")
    return Finding(check, True, detail)


def _slider(name: str, options: UrOptions) -> Finding:
    """Say whether the speed slider leaves the arm its speed: a slower one falls behind its setpoints."""
    check = f"{name}: speed slider"
    try:
        with Rtde(options.host) as controller:
            [fraction] = controller.read(["target_speed_fraction"])
    except OSError as error:
        return Finding(check, False, f"no answer by RTDE ({error})", "restart the controller")
    full = fraction > _FULL
    return Finding(
        check,
        full,
        f"{100 * fraction:.0f} %",
        "" if full else "set it to 100 % at the pendant; for a slower motion ask for a lower speed",
    )


def _corners(name: str, options: UrOptions, limits: Limits) -> Finding:
    """Say which corners of the limits the arm does not reach; a place out of reach is refused when it is asked for."""
    o = options
    reach = Reach(o.model, o.base.pose, o.hand.pose, joint_speed=o.joint_speed, margin=o.margin)
    spans = [(s.min, s.max) for s in (limits.x, limits.y, limits.height)]
    missed = [Pose((x, y, z)) for x, y, z in itertools.product(*spans) if not _reaches(reach, Pose((x, y, z)))]
    if not missed:
        return Finding(f"{name}: reach", True, "every corner of the limits")
    x, y, z = (f"{1e3 * v:g}" for v in missed[0].position)
    detail = f"{len(missed)} of 8 corners of the limits are out of reach, such as {x}, {y}, {z} mm; motions there are refused"
    return Finding(f"{name}: reach", len(missed) < 8, detail, "" if len(missed) < 8 else "check `base` and `hand`")


def _reaches(reach: Reach, corner: Pose) -> bool:
    there = PosePath([corner])
    return any(reach.obstacle(there, 1.0, start) is None for start in _STARTS)
