"""What names mean inside one tree: its keys, the file's params, readings of devices, and the task itself."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from stretch_bt.hardware.interfaces import INTERFACES, readings_of
from stretch_bt.source import Scalar, Value, closest, did_you_mean, walk
from stretch_bt.tree.document import Signature
from stretch_bt.tree.expression.typecheck import Origin, Symbol, Unresolved
from stretch_bt.tree.types import ANY, INT, Type, from_annotation, quantity
from stretch_bt.units import KINDS

__all__ = ["TASK", "TreeScope"]

#: what `task.` offers: the time since the run began and the number of the tick
TASK = {"time": quantity(KINDS["Time"].dimension), "ticks": INT}


class TreeScope:
    """The names that a body of this tree may use."""

    def __init__(self, signature: Signature) -> None:
        self.signature = signature

    def resolve(self, parts: tuple[str, ...]) -> Symbol:
        """Return the symbol of a dotted name; raises Unresolved, with a hint, when there is none."""
        first = parts[0]
        declared = self.signature.declared(first)
        if declared is not None:
            return Symbol(Origin.KEY, first, declared.type, 1)
        if first == "task":
            return self._table(parts, TASK, Origin.TASK)
        if first in self.signature.document.devices:
            return self._reading(parts)
        if first.endswith("_sd"):
            of = self.signature.declared(first.removesuffix("_sd"))
            if of is not None and of.type.is_number:
                return Symbol(Origin.SD, of.name, of.type, 1)
        param = self.signature.document.params.get(first)
        if param is not None:
            param.used = True
            return Symbol(Origin.PARAM, param.name, param.type, 1, param.value)
        raise Unresolved(len(parts) if first == "params" else 0, self._hint(parts))

    def is_doubtful(self, parts: tuple[str, ...]) -> bool:
        """Whether a name is declared, but wrongly, which was noted there and is not to be noted at each use."""
        document = self.signature.document
        declared = self.signature.declared(parts[0])
        if declared is not None:
            return declared.type is ANY
        param = document.params.get(parts[0])
        if param is not None:
            return param.doubtful or (param.value is None and not param.has_default)
        return parts[0] in document.doubtful

    def _reading(self, parts: tuple[str, ...]) -> Symbol:
        device = self.signature.document.devices[parts[0]]
        device.used = True
        return self._table(parts, _readings(device.interface), Origin.READING)

    @staticmethod
    def _table(parts: tuple[str, ...], types: Mapping[str, Type], origin: Origin) -> Symbol:
        name = parts[1] if len(parts) > 1 else ""
        type_ = types.get(name)
        if type_ is None:
            raise Unresolved(1, did_you_mean(name, types) or f"{parts[0]} has no readings")
        return Symbol(origin, ".".join(parts[:2]), type_, 2)

    @cached_property
    def _given(self) -> set[str]:
        """The outputs of all nodes in the tree."""
        nodes = (self.signature.document.node(word) for word in _words(self.signature.body))
        return {port for info in nodes if info is not None for port in info.outputs}

    def _hint(self, parts: tuple[str, ...]) -> str:
        name, signature = parts[0], self.signature
        if name == "params":
            return f"write '{'.'.join(parts[1:]) or 'depth'}': a param is called by its name alone"
        known = [*signature.names, *signature.document.devices, *signature.document.params]
        guess = closest(name, known)
        if guess is None and len(parts) > 1:
            kinds = [kind for kind, interface in INTERFACES.items() if parts[1] in _readings(interface)]
            if kinds:
                return f"add 'devices: {{{name}: {kinds[0]}}}'"
        if guess is None and (record := closest(name, self._given)) is not None:
            return f"did you mean '{record}'? Name it where it is given: '{{{record}}}'"
        others = sorted(t.name for t in signature.document.trees.values() if t is not signature and t.declared(name))
        if others and guess is None:
            return f"it belongs to tree {others[0]!r}; pass it through 'in', or write it in this tree"
        return (
            did_you_mean(name, [*known, "task"]) or "nothing in this tree writes it; write it first, or make it a param"
        )


def _words(body: Value) -> set[str]:
    """Return the words of a body that may be the names of nodes."""
    found = {key.text for key, _ in walk(body) if key is not None}
    return found | {value.text for _, value in walk(body) if isinstance(value, Scalar) and value.text.isidentifier()}


def _readings(interface: type) -> dict[str, Type]:
    return {name: from_annotation(a) for name, a in readings_of(interface).items()}
