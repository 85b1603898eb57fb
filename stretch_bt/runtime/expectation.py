"""What a mocks file expects of its run."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.errors import Diagnostic
from stretch_bt.quantity_text import format_quantity
from stretch_bt.runtime.mock_node import pattern_fits
from stretch_bt.source import Map, Mark, Scalar, Value, did_you_mean
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.document import Document
from stretch_bt.tree.types import FLOAT, Type
from stretch_bt.tree.values import ValueRefused, literal, refuse

__all__ = ["Expectation", "WantedOutput", "command_names", "wanted_output"]

#: how like two numbers are that are expected to be the same
SAME = 1e-9


@dataclass(slots=True)
class WantedOutput:
    """What an output of the task is to be: as a file has it, and in SI once the type of the output is known."""

    name: str
    mark: Mark
    given: Value
    within: Scalar | None = None
    value: Any = None
    tolerance: float | None = None
    type: Type = FLOAT

    def resolve(self, type_: Type) -> None:
        """Read the value by the type of the output; raises ValueRefused."""
        number = type_.item or type_
        self.type, self.value = type_, literal(self.given, type_, self.name)
        if self.within is None:
            return
        what = f"{self.name}.within"
        if not number.is_number:
            refuse(
                self.within.mark, "type-mismatch", f"{self.name} is {type_}, which is met or not", "leave out 'within'"
            )
        share = self.within.text.rstrip().endswith("%")
        found = literal(self.within, FLOAT if share else number, what)
        if found < 0:
            refuse(self.within.mark, "out-of-bounds", f"{what} is a tolerance, which is not below 0", "write '5 %'")
        self.tolerance = found
        if share:
            largest = max(map(abs, self.value if isinstance(self.value, list) else [self.value]), default=0.0)
            self.tolerance = found * largest

    def met(self, found: Any) -> bool:
        """Whether the output is as expected, SI; MISSING is not."""
        if isinstance(self.value, list):
            alike = isinstance(found, list) and len(found) == len(self.value)
            return alike and all(map(self._near, found, self.value))
        return self._near(found, self.value)

    def _near(self, found: Any, wanted: Any) -> bool:
        if isinstance(wanted, bool) or not isinstance(wanted, int | float) or not isinstance(found, int | float):
            return bool(found == wanted)
        if self.tolerance is None:
            return math.isclose(found, wanted, rel_tol=SAME)
        return abs(found - wanted) <= self.tolerance * (1 + SAME)

    def said(self, found: Any) -> str:
        """Return the message about an output that is another."""
        within = f" within {self.within.text.strip()}" if self.within is not None else ""
        seen = "the run gave none" if found is MISSING else f"it is {self._shown(found)}"
        return f"expected {self.name} to be {self._shown(self.value)}{within}; {seen}"

    def _shown(self, value: Any) -> str:
        if isinstance(value, list):
            return f"[{', '.join(map(self._shown, value))}]"
        number = self.type.item or self.type
        plain = isinstance(value, bool) or not isinstance(value, int | float)
        return str(value) if plain else format_quantity(value, number.dimension, 6)


@dataclass(slots=True)
class Expectation:
    """What a mocks file says of the run: its result, nodes visited and never visited, outputs, commands, and the most ticks."""

    result: str | None = None
    visited: list[tuple[str, str | None]] = field(default_factory=list)
    never: list[tuple[str, str | None]] = field(default_factory=list)
    marks: list[tuple[str, Mark]] = field(default_factory=list)  # of every pattern of `visited` and `never`
    outputs: list[WantedOutput] = field(default_factory=list)
    commands: list[tuple[str, Mark]] = field(default_factory=list)  # `device.command`, in the order that they must have
    ticks_max: int | None = None

    def unmet(
        self,
        status: str,
        ticks: int,
        seen: set[tuple[str, str]],
        outputs: Mapping[str, Any],
        commands: Sequence[str],
    ) -> list[str]:
        """Return what did not come true.

        Parameters
        ----------
        status, ticks
            How the run ended, and after how many ticks.
        seen
            (path, STATUS) of every change.
        outputs
            What the outputs of the task hold, SI or MISSING.
        commands
            Every `device.command`, in their order.
        """
        found = []
        if self.result is not None and status.lower() != self.result:
            found.append(f"expected {self.result}, the run ended with {status.lower()}")
        found += [f"expected a visit of {_show(p)}" for p in self.visited if not _seen(p, seen)]
        found += [f"expected no visit of {_show(p)}" for p in self.never if _seen(p, seen)]
        held = ((wanted, outputs.get(wanted.name, MISSING)) for wanted in self.outputs)
        found += [wanted.said(value) for wanted, value in held if not wanted.met(value)]
        found += self._uncommanded(commands)
        if self.ticks_max is not None and ticks > self.ticks_max:
            found.append(f"expected at most {self.ticks_max} ticks, took {ticks}")
        return found

    def _uncommanded(self, commands: Sequence[str]) -> list[str]:
        """Return the first command that did not come after those before it, others between them aside."""
        ahead, before = iter(commands), ""
        for wanted, _ in self.commands:
            if wanted not in ahead:
                given = ", ".join(commands[:20]) + (", ..." if len(commands) > 20 else "")
                return [f"expected {wanted}{before and f' after {before}'}; commanded were {given or 'none'}"]
            before = wanted
        return []

    def resolve(self, built: BuiltTree, document: Document) -> Iterator[Diagnostic]:
        """Hold outputs and commands against the tree that they are expected of, and yield what is wrong."""
        for wanted in self.outputs:
            if wanted.name not in built.outputs:
                hint = did_you_mean(wanted.name, built.outputs) or "the tree has no 'out'"
                yield wanted.mark.error("name-unknown", f"the tree has no output {wanted.name!r}", hint)
                continue
            try:
                wanted.resolve(built.outputs[wanted.name][0].type)
            except ValueRefused as refused:
                yield refused.diagnostic
        known = [f"{d.name}.{c}" for d in document.devices.values() for c in command_names(d.interface)]
        for name, mark in self.commands:
            if name not in known:
                hint = did_you_mean(name, known) or "the tree declares no device that is commanded"
                yield mark.error("name-unknown", f"the tree has no device with a command {name!r}", hint)


def command_names(interface: type) -> list[str]:
    """Return the commands of nodes for a device of an interface: each that takes an owner, `zero`, and `stop` for a motion."""
    methods = {name: m for name, m in vars(interface).items() if inspect.isfunction(m) and not name.startswith("_")}
    owned = [name for name, method in methods.items() if "owner" in inspect.signature(method).parameters]
    return [*owned, *(["zero"] if "zero" in methods else []), *(["stop"] if owned else [])]


def wanted_output(key: Scalar, value: Value) -> WantedOutput:
    """Return what a file expects of an output: a value, or `{value, within}`; raises ValueRefused."""
    if not isinstance(value, Map):
        return WantedOutput(key.text, key.mark, value)
    given, within = value.get("value"), value.get("within")
    if given is None or not isinstance(within, Scalar) or len(value.pairs) != 2:
        message = f"{key.text} takes a value, or a value and within what it must lie"
        refuse(value.mark, "type-mismatch", message, "write '{value: 1 N/mm, within: 5 %}'")
    return WantedOutput(key.text, key.mark, given, within)


def _seen(wanted: tuple[str, str | None], seen: set[tuple[str, str]]) -> bool:
    pattern, status = wanted
    return any(pattern_fits(pattern, path) and status in (None, s.lower()) for path, s in seen)


def _show(wanted: tuple[str, str | None]) -> str:
    return wanted[0] + (f"#{wanted[1]}" if wanted[1] else "")
