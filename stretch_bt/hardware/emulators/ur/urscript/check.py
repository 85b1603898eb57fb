"""What a controller finds wrong with a program before it runs it: names that nobody defined."""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import fields

from stretch_bt.hardware.emulators.ur.urscript.syntax import Assign, Define, Node, Run, ScriptCall, ScriptName
from stretch_bt.hardware.emulators.ur.urscript.tokens import ScriptFault

__all__ = ["check_names"]


def check_names(program: Define, functions: Container[str]) -> None:
    """Raise ScriptFault for a function or variable that is neither defined in a program nor known to the controller."""
    nodes = list(_nodes(program))
    defined = {node.name for node in nodes if isinstance(node, Define)}
    variables = {node.name for node in nodes if isinstance(node, Assign)}
    variables |= {name for node in nodes if isinstance(node, Define) for name, _ in node.parameters}
    for node in nodes:
        unknown = (
            (isinstance(node, ScriptCall) and node.name not in defined and node.name not in functions)
            or (isinstance(node, Run) and node.name not in defined)
            or (isinstance(node, ScriptName | Assign) and node.name not in variables)
        )
        if unknown and isinstance(node, ScriptCall | Run | ScriptName | Assign):
            raise ScriptFault(f"compile_error_name_not_found:{node.name}:", node.line, node.column)


def _nodes(piece: object) -> Iterator[Node]:
    """Yield a piece of a program and all that is in it."""
    if isinstance(piece, tuple):
        for item in piece:
            yield from _nodes(item)
    elif isinstance(piece, Node):
        yield piece
        for field in fields(piece):
            yield from _nodes(getattr(piece, field.name))
