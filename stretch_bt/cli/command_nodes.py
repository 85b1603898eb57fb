"""`stretch-bt nodes`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from stretch_bt.cli.output import AsJson, emit_json
from stretch_bt.cli.rows import add_row
from stretch_bt.errors import InvalidInput, TreeError
from stretch_bt.quantity_text import format_quantity
from stretch_bt.source import did_you_mean
from stretch_bt.units import KINDS

if TYPE_CHECKING:
    from stretch_bt.tree.node_info import NodeInfo

__all__ = ["command", "imported_nodes"]


def command(
    name: Annotated[str | None, typer.Argument(help="One node or construct; all when left out.")] = None,
    tree: Annotated[str | None, typer.Option(help="Also the nodes that this tree file imports.")] = None,
    json_: AsJson = False,
) -> None:
    """List the nodes that trees may use, with their ports, and the constructs of the language."""
    from stretch_bt.tree.flow import CONSTRUCTS
    from stretch_bt.tree.node_description import describe
    from stretch_bt.tree.registry import load_all
    from stretch_bt.tree.schema.constructs import describe_construct
    from stretch_bt.tree.shared_signatures import describe_shared, shared_signatures

    own = {} if tree is None else imported_nodes(tree)
    nodes, trees = {**load_all(), **own}, shared_signatures()
    known = sorted((*nodes, *trees))

    def described(key: str) -> dict[str, Any]:
        if key in CONSTRUCTS:
            return describe_construct(key)
        return describe(nodes[key]) if key in nodes else describe_shared(trees[key])

    if name is not None and name not in (*known, *CONSTRUCTS):
        raise InvalidInput(f"there is no node {name!r}; {_meant(name, [*known, *CONSTRUCTS])}")
    found = [described(key) for key in ((*known, *CONSTRUCTS) if name is None else [name])]
    if json_:
        emit_json(found)
    elif name is None:
        _list(found)
    else:
        _one(found[0])


def imported_nodes(tree: str) -> dict[str, NodeInfo]:
    """Import what a tree file names, and return the classes of behaviours that are nodes in it.

    Raises
    ------
    TreeError
        The file cannot be read, or something that it names cannot be imported.
    """
    from stretch_bt.tree.program import load_program

    program = load_program(tree)
    wrong = [found for found in program.diagnostics if found.code == "import"]
    if wrong:
        raise TreeError(wrong)
    return {name: replace(info, name=name) for name, info in program.document.classes.items()}


def _meant(name: str, known: list[str]) -> str:
    from stretch_bt.tree.expression import FUNCTIONS
    from stretch_bt.tree.program import shipped_trees
    from stretch_bt.tree.registry import RESERVED

    if name in FUNCTIONS:
        return "it is a function of expressions"
    if name == "finally":
        return "it stands under the name of a tree, beside its body"
    if name in RESERVED:
        return "it is a word that stands beside a node, as in '{press: {depth: 8 mm}, " + name + ": ...}'"
    if name in shipped_trees():
        return f"it is a shipped task: see `stretch-bt show {name}`"
    return did_you_mean(name, known) or "see `stretch-bt nodes`"


def _list(entries: list[dict[str, Any]]) -> None:
    from stretch_bt.tree.expression import FUNCTIONS

    console, table = Console(), Table(box=None, pad_edge=False, header_style="dim")
    for heading in ("node", "kind", "what it does"):
        table.add_column(heading)
    for entry in entries:
        add_row(table, entry["name"], entry["kind"], entry["doc"])
    console.print(table)
    console.print(f"\nFunctions in expressions: {', '.join(FUNCTIONS)}", highlight=False)


def _one(entry: dict[str, Any]) -> None:
    console = Console()
    console.print(f"[bold]{escape(entry['name'])}[/] ({entry['kind']}, {escape(entry['module'])})")
    console.print(entry["doc"], markup=False, emoji=False)
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in ("port", "", "type", "default", "bounds", "doc"):
        table.add_column(heading)
    for direction, key in (("in", "inputs"), ("in and out", "inouts"), ("out", "outputs")):
        for port in entry[key]:
            default = "required" if port["required"] else _shown(port["default"], port["type"])
            add_row(table, port["name"], direction, port["type"], default, _bounds(port), port["doc"])
    for device in entry["devices"]:
        add_row(table, device["name"], "device", device["type"], "required" if device["required"] else "", "", "")
    if table.row_count:
        console.print(table)
    for name, fields in entry["records"].items():
        _record(console, name, fields)


def _record(console: Console, name: str, fields: list[dict[str, Any]]) -> None:
    """Print what expressions may read of a record."""
    console.print(f"\n[bold]{escape(name)}[/], a record")
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in ("field", "type", "doc"):
        table.add_column(heading)
    for field in fields:
        add_row(table, field["name"], field["type"], field["doc"])
    console.print(table)


def _bounds(port: dict[str, Any]) -> str:
    low, high = (_shown(port.get(end), port["type"]) for end in ("min", "max"))
    if low and high:
        return f"{low} to {high}"
    return f"from {low}" if low else f"up to {high}" if high else ""


def _shown(value: Any, type_: str) -> str:
    """Return a default or a bound as a tree would have it."""
    if value is None:
        return ""
    return format_quantity(value, KINDS[type_]) if type_ in KINDS else str(value)
