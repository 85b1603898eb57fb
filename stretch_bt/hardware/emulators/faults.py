"""Faults that a stand-in can show, and those that it shows now."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean

__all__ = ["Fault", "Faults"]

_COMMON = {"times": math.inf, "seconds": math.inf}
#: least and greatest of parameters by their name; of others the last one holds
_BOUNDS: dict[str, tuple[float, float]] = {
    "times": (1, 1e9),
    "seconds": (0, 1e6),
    "delay": (0, 3600),
    "rate": (0.01, 10_000),
    "bytes": (1, 65_536),
    "part": (0, 1),
    "fraction": (0, 1),
    "code": (0, 0xFFFFFFFF),
    "unit": (0, 255),
    "opening": (0, 1),
    "locked": (0, 3600),
}
_ELSE = (-1e6, 1e6)


@dataclass(frozen=True)
class Fault:
    """A fault: what it does, its parameters with their defaults, all numbers, and its choices, which are words, the first the default.

    One that is a state, rather than something that is done to an answer, cannot be counted: it takes no `times`.
    """

    doc: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    state: bool = False
    choices: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    #: least and greatest of parameters whose name alone does not say them
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def allowed(self) -> dict[str, float]:
        """All parameters that it takes, with their defaults."""
        common = {k: v for k, v in _COMMON.items() if k != "times" or not self.state}
        return {**common, **self.parameters}


@dataclass
class _Active:
    parameters: dict[str, float]
    chosen: dict[str, str]
    left: float
    until: float


class Faults:
    """The faults of one stand-in; may be used from any thread.

    A fault stays until it is cleared, until it was shown `times` often, or until `seconds` have passed.
    """

    def __init__(self, known: Mapping[str, Fault]) -> None:
        self.known = dict(known)
        self._active: dict[str, _Active] = {}
        self._lock = threading.Lock()

    def inject(self, name: str, parameters: Mapping[str, Any] | None = None) -> None:
        """Begin to show a fault; raises InvalidInput for one that is not known, or a parameter that it does not have."""
        if name not in self.known:
            raise InvalidInput(f"there is no fault {name!r}; {did_you_mean(name, self.known)}")
        fault = self.known[name]
        numbers, chosen = fault.allowed, {key: words[0] for key, words in fault.choices.items()}
        for key, value in (parameters or {}).items():
            if key in fault.choices:
                chosen[key] = _word(name, key, value, fault.choices[key])
            elif key in fault.allowed:
                numbers[key] = _number(name, key, value, fault.bounds.get(key) or _BOUNDS.get(key, _ELSE))
            else:
                known = [*fault.allowed, *fault.choices]
                raise InvalidInput(f"the fault {name!r} has no parameter {key!r}; {did_you_mean(key, known)}")
        with self._lock:
            left, until = numbers.get("times", math.inf), time.monotonic() + numbers["seconds"]
            self._active[name] = _Active(numbers, chosen, left, until)

    def clear(self, name: str | None = None) -> None:
        """End a fault, or all of them; raises InvalidInput for one that is not known."""
        if name is not None and name not in self.known:
            raise InvalidInput(f"there is no fault {name!r}; {did_you_mean(name, self.known)}")
        with self._lock:
            for gone in [name] if name is not None else list(self._active):
                self._active.pop(gone, None)

    def active(self) -> list[str]:
        """Return the names of the faults that are shown now."""
        return [name for name in self.known if self.shown(name) is not None]

    def shown(self, name: str) -> dict[str, float] | None:
        """Return the parameters of a fault that is active, without counting it as shown."""
        with self._lock:
            found = self._active.get(name)
            if found is not None and (found.left < 1 or time.monotonic() > found.until):
                del self._active[name]
                found = None
            return None if found is None else dict(found.parameters)

    def meets(self, name: str, **asked: str) -> bool:
        """Whether a fault is active and was set to meet this, as `connection="control"`; its first choice of a kind meets all of it."""
        if self.shown(name) is None:
            return False
        with self._lock:
            found = self._active.get(name)
            choices = self.known[name].choices
            return found is not None and all(
                found.chosen[key] in (choices[key][0], word) for key, word in asked.items()
            )

    def chosen(self, name: str) -> Mapping[str, str]:
        """Return the choices of a fault that is active; none for another."""
        with self._lock:
            return dict(self._active[name].chosen) if name in self._active else {}

    def take(self, name: str) -> dict[str, float] | None:
        """Return the parameters of a fault that is to be shown now, and count it."""
        parameters = self.shown(name)
        if parameters is not None:
            with self._lock:
                if name in self._active:
                    self._active[name].left -= 1
        return parameters


def _number(name: str, key: str, value: object, bounds: tuple[float, float]) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InvalidInput(f"{key} of the fault {name!r} must be a finite number, not {value!r}")
    least, most = bounds
    if not least <= value <= most:
        raise InvalidInput(f"{key} of the fault {name!r} must be from {least:g} to {most:g}, not {value!r}")
    return float(value)


def _word(name: str, key: str, value: object, words: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in words:
        raise InvalidInput(f"{key} of the fault {name!r} is one of {', '.join(words)}, not {value!r}")
    return value
