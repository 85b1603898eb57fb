"""Files of the older form of the language, respelt: params by their names alone, `guard` for `while`, words beside nodes, short ports.

It works on the text, so comments and layout stay. What it cannot decide it leaves, and notes at its place.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import yaml

from stretch_bt.errors import Diagnostic
from stretch_bt.source.syntax import lines_of
from stretch_bt.tree.registry import RESERVED, RETIRED

__all__ = ["Respelt", "respell", "without_pair"]

#: constructs whose braces hold no places, and those in which a name may stand
_NO_PORTS = (
    "set",
    "invert",
    "force_success",
    "force_failure",
    "in",
    "out",
    "inout",
    "keys",
    "params",
    "with",
    "do",
    "children",
    "trees",
    "finally",
    "imports",
    "devices",
    "collect",
)
_CONDITIONS = ("check", "guard")
_HEADINGS = ("format", "doc", "imports", "devices", "scene", "tick", "trees", "run", "main", "collect", "as", "that")
_WORDS = (*RESERVED, *RETIRED)
_PARAM = re.compile(r"\bparams\.(?=[A-Za-z_])")

Pair = tuple[yaml.ScalarNode, yaml.Node]


@dataclass(slots=True)
class Respelt:
    """The text of a file in the present form, and what was left to its author."""

    text: str
    left: list[Diagnostic] = field(default_factory=list)


def respell(text: str, file: str = "") -> Respelt:
    """Return the text of a tree file, or of the body of a tree, in the present form."""
    found = Respelt(text)
    for change in (_word_renamed, _word_moved):
        while (changed := change(found.text)) is not None:
            found.text = changed
    found.text = _shortened(_params_named(found.text, file, found.left))
    return found


def _root(text: str) -> yaml.Node | None:
    return yaml.compose(text, Loader=yaml.SafeLoader)


def _maps(node: yaml.Node | None) -> Iterator[yaml.MappingNode]:
    """Yield every mapping in which places may stand, from the outside in."""
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _maps(item)
    elif isinstance(node, yaml.MappingNode):
        yield node
        for key, value in node.value:
            if key.value not in ("params", "keys", "devices", "imports", "in", "out", "inout", "set"):
                yield from _maps(value)


def _word_renamed(text: str) -> str | None:
    """Return the text with the next word of older files spelt as now."""
    for mapping in _maps(_root(text)):
        for key, _ in mapping.value:
            if key.value in RETIRED:
                return _put(text, key.start_mark.index, key.end_mark.index, RETIRED[key.value])
    return None


def _word_moved(text: str) -> str | None:
    """Return the text with the next word that stands among ports put beside its node."""
    root = _root(text)
    trees, python = _heading(root, "trees"), _python_imports(root)
    for mapping in _maps(root):
        for key, value in mapping.value:
            if mapping is trees or not isinstance(value, yaml.MappingNode) or not _is_place(key, value):
                continue
            if _is_class(key.value, python):
                continue  # what stands in its braces are its own arguments, whatever they are called
            for inner in value.value:
                if _stands_beside(inner[0].value, key.value):
                    return _moved(text, mapping, (key, value), inner)
    return None


def _heading(root: yaml.Node | None, word: str) -> yaml.Node | None:
    """Return what a file has under a heading, such as its trees, whose words stand beside their bodies; None of the body of one tree."""
    pairs = root.value if isinstance(root, yaml.MappingNode) else ()
    return next((value for key, value in pairs if key.value == word), None)


def _python_imports(root: yaml.Node | None) -> set[str]:
    """Return the names under which a file imports modules and classes of Python."""
    table = _heading(root, "imports")
    pairs = table.value if isinstance(table, yaml.MappingNode) else ()
    return {key.value for key, value in pairs if not str(value.value).endswith((".yaml", ".yml"))}


def _is_class(word: str, python: set[str]) -> bool:
    """Whether a word names a class of behaviours: the import of one, or one in a module, which is not in snake case."""
    prefix, dot, _ = word.partition(".")
    return prefix in python and (not dot or word.rpartition(".")[2][:1].isupper())


def _is_place(key: yaml.ScalarNode, value: yaml.MappingNode) -> bool:
    """Whether a pair is a node, a call or a construct with its ports or fields; a word such as `timeout` is one with a `do`."""
    inside = [inner.value for inner, _ in value.value]
    return key.value not in _NO_PORTS and (key.value not in _WORDS or "do" in inside)


def _stands_beside(word: str, place: str) -> bool:
    """Whether a word among the ports of a place belongs beside it."""
    return word in _WORDS and word != "finally" and not (word == "name" and place in _CONDITIONS)


def _moved(text: str, place: yaml.MappingNode, node: tuple[yaml.ScalarNode, yaml.MappingNode], inner: Pair) -> str:
    """Put one word beside a node: in the braces around it, in new ones where it stands in a list without, else on a line of its own."""
    key, value = node
    written = f"{inner[0].value}:{_given(text, inner[1], key.start_mark.column + 2)}"
    start, end = place.start_mark.index, value.end_mark.index
    rest = without_pair(text, value, inner[0])
    grown = len(rest) - len(text)
    if place.flow_style and text[start] == "{":
        return _put(rest, key.start_mark.index, key.start_mark.index, f"{written}, ")
    if place.flow_style:
        rest = _put(rest, end + grown, end + grown, "}")
        return _put(rest, key.start_mark.index, key.start_mark.index, f"{{{written}, ")
    return _put(rest, key.start_mark.index, key.start_mark.index, f"{written}\n{' ' * key.start_mark.column}")


def _given(text: str, value: yaml.Node, column: int) -> str:
    """Return the text of a value as it stands after a colon; a block goes on lines of its own, at a column."""
    body = text[value.start_mark.index : value.end_mark.index].rstrip()
    if not isinstance(value, yaml.CollectionNode) or value.flow_style:
        return f" {body}"
    first, *others = body.splitlines()
    # a comment may stand farther to the left
    lines = [first, *(line[min(value.start_mark.column, len(line) - len(line.lstrip())) :] for line in others)]
    return "".join(f"\n{' ' * column}{line}" for line in lines)


def without_pair(text: str, mapping: yaml.MappingNode, key: yaml.ScalarNode) -> str:
    """Return the text without one pair of a mapping, the lines of which go where it is no mapping in braces."""
    pairs = mapping.value
    at = next(i for i, (other, _) in enumerate(pairs) if other is key)
    start, end = key.start_mark.index, pairs[at][1].end_mark.index
    if not mapping.flow_style:
        end = len(text[:end].rstrip())  # a block ends where the next word begins
        end = text.find("\n", end if text[end - 1 : end] != "\n" else end - 1)
        start = text.rfind("\n", 0, start)
        if (
            at == 0
            and pairs[0][0].start_mark.line == mapping.start_mark.line
            and not text[start : key.start_mark.index].isspace()
        ):
            return _put(text, key.start_mark.index, pairs[1][0].start_mark.index, "")
        return _put(text, start, len(text) if end < 0 else end, "")
    if at + 1 < len(pairs):
        return _put(text, start, pairs[at + 1][0].start_mark.index, "")
    return _put(text, pairs[at - 1][1].end_mark.index if at else start, end, "")


def _put(text: str, start: int, end: int, new: str) -> str:
    return text[:start] + new + text[end:]


def _params_named(text: str, file: str, left: list[Diagnostic]) -> str:
    """Return the text with params called by their names alone; a name that is a key's too is left."""
    root = _root(text)
    taken = set(_names_of_keys(root))
    edits = []
    for node in _scalars(root):
        for match in _PARAM.finditer(text, node.start_mark.index, node.end_mark.index):
            word = re.match(r"\w+", text[match.end() :])
            name = word[0] if word else ""
            if name in taken:
                before = lines_of(text[: match.start()])
                line, column = len(before), len(before[-1]) + 1
                message = f"params.{name} would be {name!r}, which is the name of a key too"
                left.append(
                    Diagnostic(
                        file,
                        line,
                        column,
                        "error",
                        "retired",
                        message,
                        "rename one of them, and write it without 'params.'",
                        7,
                    )
                )
            else:
                edits.append(match.span())
    for start, end in sorted(set(edits), reverse=True):  # an alias is its anchor once more
        text = _put(text, start, end, "")
    return text


def _shortened(text: str) -> str:
    """Return the text with each port that is wired to the key of its own name written short."""
    edits = []
    for mapping in _maps(_root(text)):
        for key, value in mapping.value:
            if isinstance(value, yaml.MappingNode) and _has_ports(key.value):
                edits += [_short_edit(value, pair) for pair in value.value if _repeats(pair)]
    for start, end, new in sorted(set(edits), reverse=True):
        text = _put(text, start, end, new)
    return text


def _has_ports(word: str) -> bool:
    """Whether a word names a node or a tree: no construct, heading or field."""
    from stretch_bt.tree.flow import CONSTRUCTS

    return word not in (*CONSTRUCTS, *_WORDS, *_HEADINGS, *_NO_PORTS) or word == "with"


def _repeats(pair: Pair) -> bool:
    key, value = pair
    return isinstance(value, yaml.ScalarNode) and value.style is None and value.value == f"${key.value}"


def _short_edit(mapping: yaml.MappingNode, pair: Pair) -> tuple[int, int, str]:
    key, value = pair
    return key.start_mark.index, value.end_mark.index, key.value if mapping.flow_style else f"{key.value}:"


def _scalars(node: yaml.Node | None) -> Iterator[yaml.ScalarNode]:
    if isinstance(node, yaml.ScalarNode):
        yield node
    elif isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _scalars(item)
    elif isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value not in ("doc", "fail", "log"):  # prose
                yield from _scalars(value)


def _names_of_keys(node: yaml.Node | None) -> Iterator[str]:
    """Yield the names that the trees of a file declare or write."""
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _names_of_keys(item)
    elif isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value in ("in", "out", "inout", "keys", "set") and isinstance(value, yaml.MappingNode):
                yield from (name.value.removeprefix("$") for name, _ in value.value)
            elif key.value == "as" and isinstance(value, yaml.ScalarNode):
                yield value.value.removeprefix("$")
            elif key.value != "params":
                yield from _names_of_keys(value)
