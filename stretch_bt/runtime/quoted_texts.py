"""Texts that a `set` of an older file gives bare, where a bare word is a name now: put into quotes of their own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import yaml

from stretch_bt.errors import Diagnostic, TreeError
from stretch_bt.source import Scalar
from stretch_bt.tree.document import Signature
from stretch_bt.tree.expression import ExpressionError, parse
from stretch_bt.tree.expression.parse import Constant
from stretch_bt.tree.program import load_program
from stretch_bt.tree.types import Family
from stretch_bt.tree.wiring import Wiring

__all__ = ["quoted_texts", "texts_read_as_names"]

Place = tuple[Signature, str, yaml.ScalarNode]


def quoted_texts(text: str, path: Path) -> str:
    """Return the text of a tree file with each text in a `set` quoted that cannot be read as an expression."""
    try:
        trees = load_program(path, text=text).document.trees
    except TreeError:
        return text
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    edits = {_span(node): new for place in _places(root, trees) if (node := place[2]) and (new := _quoted(*place))}
    for (start, end), new in sorted(edits.items(), reverse=True):
        text = text[:start] + new + text[end:]
    return text


def texts_read_as_names(text: str, path: Path, file: str) -> list[Diagnostic]:
    """Return a warning for each text in a `set` of an older file that has the name of a key or a param, which it is read as now."""
    try:
        trees = load_program(path, text=text).document.trees
    except TreeError:
        return []
    places = (place for place in _places(yaml.compose(text, Loader=yaml.SafeLoader), trees) if _is_name(*place))
    return [_named(key, value, file) for _, key, value in places]


def _named(key: str, value: yaml.ScalarNode, file: str) -> Diagnostic:
    mark = value.start_mark
    message = f"{value.value!r} was a text in the older form, and {key!r} gets the value of that name now"
    hint = f"write {_in_quotes(value.value)} if the text is meant, '${value.value}' if the name is"
    return Diagnostic(file, mark.line + 1, mark.column + 1, "warning", "retired", message, hint, len(value.value))


def _is_name(tree: Signature, key: str, value: yaml.ScalarNode) -> bool:
    """Whether a bare word that a key of text is given names what the tree knows."""
    if not _may_be_text(tree, key, value):
        return False
    return value.style is None and value.value.isidentifier() and _quoted(tree, key, value) is None


def _span(node: yaml.Node) -> tuple[int, int]:
    return node.start_mark.index, node.end_mark.index


def _places(root: yaml.Node | None, trees: dict[str, Signature]) -> Iterator[Place]:
    """Yield what each `set` of each tree gives a key on one line: the tree, the key and the value."""
    for heading, bodies in _pairs(root):
        for name, body in _pairs(bodies) if heading == "trees" else ():
            for mapping in _sets(body) if name in trees else ():
                for key, value in _pairs(mapping):
                    if isinstance(value, yaml.ScalarNode) and value.style not in ("|", ">"):
                        yield trees[name], key.removeprefix("$"), value


def _sets(node: yaml.Node) -> Iterator[yaml.Node]:
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _sets(item)
    for key, value in _pairs(node):
        if key == "set":
            yield value
        elif key not in ("params", "keys", "in", "out", "inout"):
            yield from _sets(value)


def _pairs(node: yaml.Node | None) -> list[tuple[str, yaml.Node]]:
    return [(key.value, value) for key, value in node.value] if isinstance(node, yaml.MappingNode) else []


def _quoted(tree: Signature, key: str, value: yaml.ScalarNode) -> str | None:
    """Return a text in quotes of its own; None where it is no text, is one already, or names what the tree knows."""
    declared, text = tree.declared(key), value.value
    if declared is None or not _may_be_text(tree, key, value):
        return None
    wiring = Wiring(tree)
    wiring.expression(Scalar(text, value.style is not None, tree.mark), declared.type, key)
    return _in_quotes(text) if wiring.diagnostics else None


def _may_be_text(tree: Signature, key: str, value: yaml.ScalarNode) -> bool:
    """Whether the value given to a key was a text in an older file: the key holds text, and it is neither a reference nor absence."""
    declared, text = tree.declared(key), value.value
    holds_text = declared is not None and declared.type.family in (Family.STR, Family.ENUM)
    return holds_text and not (text.startswith("$") or (text == "none" and value.style is None))


def _in_quotes(text: str) -> str | None:
    """Return a text as an expression in YAML; None where no quotes of the language hold it."""
    expression = f'"{text}"' if "'" in text else f"'{text}'"
    try:
        found = parse(expression)
    except ExpressionError:
        return None
    if not text.isprintable() or not isinstance(found, Constant) or found.value != text:
        return None
    return (
        f'"{expression}"'
        if '"' not in text + expression and "\\" not in text
        else "'" + expression.replace("'", "''") + "'"
    )
