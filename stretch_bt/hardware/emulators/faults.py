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


@dataclass(frozen=True)
class Fault:
    """A fault: what it does, and its parameters with their defaults, all numbers."""

    doc: str
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass
class _Active:
    parameters: dict[str, float]
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
        allowed = {**_COMMON, **self.known[name].parameters}
        for key, value in (parameters or {}).items():
            if key not in allowed:
                raise InvalidInput(f"the fault {name!r} has no parameter {key!r}; {did_you_mean(key, allowed)}")
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise InvalidInput(f"{key} of the fault {name!r} must be a finite number, not {value!r}")
        values = {**allowed, **(parameters or {})}
        with self._lock:
            self._active[name] = _Active(values, values["times"], time.monotonic() + values["seconds"])

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

    def take(self, name: str) -> dict[str, float] | None:
        """Return the parameters of a fault that is to be shown now, and count it."""
        parameters = self.shown(name)
        if parameters is not None:
            with self._lock:
                if name in self._active:
                    self._active[name].left -= 1
        return parameters
