"""Values handed over to a behaviour, and taken from it, through the Blackboard of py_trees."""

from __future__ import annotations

from copy import copy
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard

__all__ = ["PortBoard"]

_NOTHING = object()


class PortBoard:
    """The places on the Blackboard of one behaviour's ports, which nothing else reads or writes."""

    def __init__(self, behaviour: Behaviour, inputs: list[str], outputs: list[str]) -> None:
        self.inputs = inputs
        self._outputs = outputs
        self._keys = {name: f"/{behaviour.id.hex}/{name}" for name in (*inputs, *outputs)}
        self._seen: dict[str, Any] = {}
        self._written: set[str] = set()
        set_output: Any = getattr(behaviour, "_set_output", None)
        if set_output is not None:

            def noted(name: str, value: Any) -> None:
                """Write an output, and note it: the same list may be written again, longer."""
                self._written.add(name)
                set_output(name, value)

            vars(behaviour)["_set_output"] = noted
        self._reset = getattr(behaviour, "reset_port", None)
        setup_ports: Any = getattr(behaviour, "setup_ports", None)
        if setup_ports is not None:
            setup_ports(port_remappings=dict(self._keys))

    def begin(self) -> None:
        """Forget the outputs of the start before: an output that this start does not write is not written."""
        for name in self._outputs:
            if self._reset is not None:
                self._reset(name)
        self._seen = {}
        self._written.clear()

    def give(self, name: str, value: Any) -> None:
        """Put the value of an input where the behaviour reads it; None takes it away."""
        if value is None:
            Blackboard.unset(self._keys[name])
        else:
            Blackboard.set(self._keys[name], value)

    def take(self) -> dict[str, Any]:
        """Return the outputs that the behaviour wrote since they were last taken."""
        found = {}
        for name in self._outputs:
            value = Blackboard.storage.get(self._keys[name], _NOTHING)
            again = name in self._written or value is not self._seen.get(name, _NOTHING)
            if value is not _NOTHING and again:
                self._seen[name] = value
                found[name] = copy(value)  # which the behaviour may go on to change
        self._written.clear()
        return found

    def unwritten(self) -> list[str]:
        """Return the outputs that the behaviour did not write since it began."""
        return [name for name in self._outputs if name not in self._seen]
