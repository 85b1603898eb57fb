"""Rewriting a tree file of the older form: `check --fix`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import yaml

from stretch_bt.errors import Diagnostic
from stretch_bt.source import read_text
from stretch_bt.tree.program import load_program
from stretch_bt.tree.respell import respell, without_pair

__all__ = ["fix_tree"]


def fix_tree(path: Path) -> list[Diagnostic]:
    """Respell a tree file in place, comments kept, and return what is left to its author.

    Declarations of keys go where nothing but the type is declared and that follows from what writes the key. A file that is not YAML,
    or one of the present form, stays as it is.

    Raises
    ------
    FileError
        The file cannot be read.
    """
    text = read_text(path, str(path))
    try:
        found = respell(text, str(path))
    except yaml.YAMLError:
        return []
    new = found.text if found.left else _undeclared(found.text, path)
    if new != text:
        path.write_text(new, encoding="utf-8")
    return found.left


def _undeclared(text: str, path: Path) -> str:
    """Return the text without the declarations of keys that need none: each one that the file is as right without."""
    if load_program(path, text=text).errors:
        return text
    for name in list(_bare_keys(text)):
        without = _without(text, name)
        if without is not None and not load_program(path, text=without).errors:
            text = without
    return text


def _bare_keys(text: str) -> Iterator[str]:
    """Yield the keys of the file that are declared with their type alone and without a comment."""
    for mapping in _keys(yaml.compose(text, Loader=yaml.SafeLoader)):
        for key, value in mapping.value:
            if _is_bare(text, mapping, key, value):
                yield key.value


def _is_bare(text: str, mapping: yaml.MappingNode, key: yaml.ScalarNode, value: yaml.Node) -> bool:
    line = text[key.start_mark.index : text.find("\n", value.end_mark.index)]
    return isinstance(value, yaml.ScalarNode) and (mapping.flow_style or "#" not in line)


def _keys(node: yaml.Node | None) -> Iterator[yaml.MappingNode]:
    """Yield each mapping of declared keys: of `main`, at the top of the file, and of each tree."""
    if not isinstance(node, yaml.MappingNode):
        return
    for key, value in node.value:
        if key.value == "keys" and isinstance(value, yaml.MappingNode):
            yield value
        elif key.value == "trees" and isinstance(value, yaml.MappingNode):
            for _, tree in value.value:
                yield from _keys(tree)


def _without(text: str, name: str) -> str | None:
    """Return the text without the first bare declaration of a key; the last one takes the heading with it."""
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    for mapping in _keys(root):
        for key, value in mapping.value:
            if key.value == name and _is_bare(text, mapping, key, value):
                alone = len(mapping.value) == 1
                return _without_heading(text, mapping) if alone else without_pair(text, mapping, key)
    return None


def _without_heading(text: str, mapping: yaml.MappingNode) -> str:
    heading = text.rfind("keys", 0, mapping.start_mark.index)
    before = text[text.rfind("\n", 0, heading) + 1 : heading]
    if before.strip():  # in braces
        after = re.match(r"\s*,\s*", text[mapping.end_mark.index :])
        return text[:heading] + text[mapping.end_mark.index + (after.end() if after else 0) :]
    last = mapping.value[-1][1].end_mark.index if not mapping.flow_style else mapping.end_mark.index
    first, end = text.rfind("\n", 0, heading) + 1, text.find("\n", last)
    return text[:first] + ("" if end < 0 else text[end + 1 :])
