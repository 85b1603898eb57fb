"""Where the standard deviation of a value is lost: expressions carry none, and what comes after would take the value for exact."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.errors import Diagnostic
from stretch_bt.tree.document import Signature
from stretch_bt.tree.expression import Expression, names
from stretch_bt.tree.expression.parse import Name
from stretch_bt.tree.expression.typecheck import Origin
from stretch_bt.tree.flow import Call, Leaf
from stretch_bt.tree.flow.base import Wire
from stretch_bt.tree.flow.set_keys import SetKeys
from stretch_bt.tree.scope import TreeScope
from stretch_bt.tree.tree_body import TreeBody
from stretch_bt.tree.types import Family, Type, attributes

__all__ = ["lost_errors"]

_MEASURED = (Family.QUANTITY, Family.FLOAT)


def lost_errors(body: TreeBody) -> Iterator[Diagnostic]:
    """Yield a warning for each expression whose value has no error: where a port asks for one, and in a `set` of what an error goes with."""
    found = _LostErrors(body)
    yield from found.at_ports()
    yield from found.in_sets()


class _LostErrors:
    def __init__(self, body: TreeBody) -> None:
        self.signature: Signature = body.signature
        self.scope = TreeScope(body.signature)
        parts = list(body.parts())
        self.leaves = [part for part in parts if isinstance(part, Leaf)]
        self.sets = [part for part in parts if isinstance(part, SetKeys)]
        self.carrying = self._carrying([part for part in parts if isinstance(part, Call)])

    def at_ports(self) -> Iterator[Diagnostic]:
        for leaf in self.leaves:
            for name, wire in leaf.inputs.items():
                if not self._asks(leaf, name) or wire.is_constant or wire.source is not None:
                    continue
                message = f"{wire.text!r} is worked out, so that it has no standard deviation, and '{name}_sd' keeps its default"
                hint = f"add '{name}_sd: ...', or give it beside the value in a 'set'"
                yield wire.mark.warning("deviation-lost", message, hint)

    def in_sets(self) -> Iterator[Diagnostic]:
        asked = self._asked()
        for part in self.sets:
            for key, wire in part.wires.items():
                lost = self._lost(wire) if key in asked and key not in part.sds else []
                if not lost:
                    continue
                message = f"{wire.text!r} is worked out, so that {key!r} has no standard deviation, and {', '.join(lost)} may have one"
                errors = " and ".join(f"'{name}_sd'" for name in lost)
                yield wire.mark.warning("deviation-lost", message, f"set '{key}_sd' beside it, from {errors}")

    def _lost(self, wire: Wire) -> list[str]:
        """Return the names in an expression whose error it does not carry on."""
        if wire.expression is None or wire.is_constant or wire.source is not None:
            return []
        return list(dict.fromkeys(".".join(name.parts) for name in names(wire.expression) if self._has_error(name)))

    def _asked(self) -> set[str]:
        """Return the keys whose error somebody may look for: outputs of the tree, and keys for a port beside which an error may stand."""
        outs = {out.name for out in self.signature.outs.values() if out.type.family in _MEASURED}
        wires = [wire for leaf in self.leaves for name, wire in leaf.inputs.items() if self._asks(leaf, name)]
        return outs | {key for wire in wires for key, _ in wire.reads}

    @staticmethod
    def _asks(leaf: Leaf, name: str) -> bool:
        """Whether a node has a port for the error of this port's value, which nothing is wired to."""
        return f"{name}_sd" in leaf.info.ports and f"{name}_sd" not in leaf.inputs

    def _carrying(self, calls: list[Call]) -> set[str]:
        """Return the keys that may hold a value with an error."""
        found = {
            key
            for leaf in self.leaves
            for name, (key, _) in leaf.outputs.items()
            if _may(name, leaf.info.outputs[name])
        }
        found |= {
            key
            for call in calls
            for name, (key, _) in call.outputs.items()
            if name in call.target.outs and _may(name, call.target.outs[name].type)
        }
        self.carrying = found
        while True:  # what a `set` hands on, also what it took from another one
            more = {key for part in self.sets for key, wire in part.wires.items() if self._hands_on(part, key, wire)}
            if more <= found:
                return found
            found |= more

    def _hands_on(self, part: SetKeys, key: str, wire: Wire) -> bool:
        source: Expression | None = wire.source
        return key in part.sds or (source is not None and any(self._has_error(name) for name in names(source)))

    def _has_error(self, name: Name) -> bool:
        """Whether a name may stand for a value with an error: a key, or a field beside which a record has one."""
        symbol = self.scope.resolve(name.parts)
        if symbol.origin is not Origin.KEY:
            return False
        *path, last = name.parts[symbol.used - 1 :]
        if not path:
            return symbol.name in self.carrying
        cls = _followed(symbol.type, path[1:]).cls
        return cls is not None and f"{last}_sd" in attributes(cls)


def _may(name: str, type_: Type) -> bool:
    return type_.family is Family.QUANTITY and not name.endswith("_sd")


def _followed(type_: Type, path: list[str]) -> Type:
    """Return the type of an attribute of an attribute, or of an item of a list."""
    for part in path:
        type_ = (
            type_.item if type_.item is not None else attributes(type_.cls)[part] if type_.cls is not None else type_
        )
    return type_
