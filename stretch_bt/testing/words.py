"""The words of a script: text and plain numbers for what a device says, so that a test imports nothing for them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from stretch_bt.errors import DeviceFault, DeviceLost, InvalidInput, NoAnswer
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.plain_numbers import is_number
from stretch_bt.source import did_you_mean
from stretch_bt.units import KINDS

__all__ = ["motion_states", "script_values"]

#: first words of a text that is raised instead of given
_RAISED: dict[str, Callable[[str, str], Exception]] = {
    "fault": DeviceLost,
    "no answer": lambda _, reason: NoAnswer(reason),
}
#: meaning of a number, by the name in a script: the reading, its unit, and how it is made
_MADE: dict[str, tuple[str, str, Callable[[float], Any]]] = {
    "force": ("wrench", "Force", lambda force: Wrench((0.0, 0.0, force))),
    "wrench": ("wrench", "Force", lambda force: Wrench((0.0, 0.0, force))),
    "height": ("pose", "Length", lambda height: Pose((0.0, 0.0, height))),
    "pose": ("pose", "Length", lambda height: Pose((0.0, 0.0, height))),
    "opening": ("opening", "Length", float),
    "force_noise": ("force_noise", "Force", float),
}
#: by the kind of a device: readings that its script may give
_KNOWN: dict[str, tuple[str, ...]] = {
    "Arm": ("force", "force_noise", "height", "pose", "wrench"),
    "Gripper": ("opening",),
    "DepthCamera": ("frame",),
    "ForceSensor": ("force", "wrench"),
    "Operator": (),
}


def script_values(kind: str, script: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Return what each reading of a device gives, one after the other.

    Raises
    ------
    InvalidInput
        A name is no reading of such a device, or a text no quantity; the message says what to write.
    """
    found: dict[str, list[Any]] = {}
    for name, given in script.items():
        if name not in _KNOWN[kind]:
            raise InvalidInput(f"the script of a {kind} has no {name!r}; {_has(kind, name)}")
        values = list(given) if isinstance(given, list | tuple) else [given]
        if not values:
            raise InvalidInput(f"the script of a {kind} gives no value of {name!r}; write at least one")
        reading = _MADE[name][0] if name in _MADE else name
        if reading in found:
            raise InvalidInput(f"the script of a {kind} gives its {reading} twice, by {name!r} too; leave out one")
        found[reading] = [_value(kind, name, value) for value in values]
    return found


def _has(kind: str, name: str) -> str:
    """Return what a script has instead of a name."""
    known = ", ".join(_KNOWN[kind])
    hint = did_you_mean(name, _KNOWN[kind])
    alike = f"{hint} " if hint.startswith("did") else ""
    return f"{alike}it has {known}" if known else "leave it out, it gives no reading"


def motion_states(kind: str, states: Iterable[Any]) -> list[MotionState | DeviceFault | NoAnswer]:
    """Return the states of a motion: given as such or by their words, exceptions as `fault: why` or `no answer: why`."""
    found = [_raised(kind, state) or _state(kind, state) for state in states]
    if not found:
        raise InvalidInput(f"a motion of a {kind} has at least one state; write ['moving', 'done']")
    return found


def _state(kind: str, state: Any) -> Any:
    if not isinstance(state, str):
        return state
    words = [one.value for one in MotionState]
    if state not in words:
        raise InvalidInput(
            f"a motion of a {kind} has no state {state!r}; {did_you_mean(state, [*words, 'fault: why'])}"
        )
    return MotionState(state)


def _value(kind: str, name: str, value: Any) -> Any:
    raised = _raised(kind, value)
    if raised is not None or name not in _MADE:
        return value if raised is None else raised
    _, unit, make = _MADE[name]
    if isinstance(value, str):
        try:
            return make(KINDS[unit].parse(value))
        except InvalidInput as error:
            raise InvalidInput(f"the script of a {kind}, {name}: {error}") from None
    if (isinstance(value, float) and not math.isfinite(value)) or (make is float and not is_number(value)):
        hint = "write a number that one can give, or 'no answer: why'"
        raise InvalidInput(f"the script of a {kind}, {name}: no device gives {value}; {hint}")
    return make(float(value)) if is_number(value) else value


def _raised(kind: str, value: Any) -> Any:
    begins, colon, reason = value.partition(":") if isinstance(value, str) else ("", "", "")
    if not colon or begins.strip() not in _RAISED:
        return value if isinstance(value, DeviceFault | NoAnswer) else None
    return _RAISED[begins.strip()](kind.lower(), reason.strip())
