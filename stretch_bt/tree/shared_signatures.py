"""What crosses the borders of shipped trees that are called like nodes, for whoever lists nodes."""

from __future__ import annotations

import inspect
from functools import cache
from typing import Any

from stretch_bt.tree.document import Declared, Signature
from stretch_bt.tree.headings import read_document
from stretch_bt.tree.keys import settle_types
from stretch_bt.tree.node_description import records_of
from stretch_bt.tree.port import Port
from stretch_bt.tree.shared import SHARED, shipped

__all__ = ["KIND", "describe_shared", "shared_signatures"]

KIND = "tree"


@cache
def shared_signatures() -> dict[str, Signature]:
    """Return them by name, each name with its type."""
    documents = {file: read_document(shipped(file), file) for file in sorted(set(SHARED.values()))}
    found = {name: documents[file].trees[name] for name, file in SHARED.items()}
    for signature in found.values():
        settle_types(signature)
    return found


def describe_shared(signature: Signature) -> dict[str, Any]:
    """Return what `nodes --json` prints of one, in the form of a node."""
    return {
        "name": signature.name,
        "kind": KIND,
        "doc": signature.doc,
        "module": signature.document.file,
        "inputs": [_entry(d, d.name, not d.has_default) for d in signature.ins.values()],
        "outputs": [entry for d in signature.outs.values() for entry in _written(d, signature)],
        "inouts": [_entry(d, d.name, not d.has_default) for d in signature.inouts.values()],
        "devices": [],
        "records": records_of(
            d.type for table in (signature.ins, signature.outs, signature.inouts) for d in table.values()
        ),
    }


def _written(declared: Declared, signature: Signature) -> list[dict[str, Any]]:
    """Return an output, and its standard deviation where it is a number."""
    names = [declared.name, *(name for name, out in signature.deviations.items() if out is declared)]
    return [_entry(declared, name, False) for name in names]


def _entry(declared: Declared, name: str, required: bool) -> dict[str, Any]:
    kind, bounds = declared.type.kind, {"min": declared.min, "max": declared.max}
    doc = _doc(declared) or (inspect.getdoc(declared.type.cls) if declared.type.cls else "") or declared.name
    return {
        "name": name,
        "type": declared.type.name,
        "unit": kind.si_unit if kind else None,
        "default": declared.default if isinstance(declared.default, int | float | str) else None,
        "required": required,
        "doc": doc.partition("\n")[0] if name == declared.name else f"standard deviation of {declared.name}",
    } | {word: value for word, value in bounds.items() if value is not None}


def _doc(declared: Declared) -> str:
    """Return the purpose of a name, as its file or a port that it reaches says."""
    reached = (port.doc if isinstance(port, Port) else _doc(port) for port in declared.reaches)
    return declared.doc or next((doc for doc in reached if doc), "")
