"""Rewriting a tree file of the older form: `check --fix`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from shutil import copymode

import yaml

from stretch_bt.errors import Diagnostic, FileError, InvalidInput
from stretch_bt.runtime.apart import apart
from stretch_bt.runtime.quoted_texts import quoted_texts, texts_read_as_names
from stretch_bt.source import Map, Scalar, Value, parse, read_text
from stretch_bt.tree.headings import FORMAT
from stretch_bt.tree.program import find_tree, load_program
from stretch_bt.tree.respell import respell, without_pair

__all__ = ["fix_files", "fix_tree"]


def fix_files(files: Iterable[str]) -> list[Diagnostic]:
    """Respell the tree files among those that are named, and return what is left to their authors.

    What cannot be read is left to the check, which says why; shipped trees are of the present form.

    Raises
    ------
    InvalidInput
        A file cannot be written.
    """
    left = []
    for file in files:
        with apart(), suppress(FileError):
            if find_tree(file)[0] == Path(file):
                left += fix_tree(Path(file), file)
    return left


def fix_tree(path: Path, name: str | None = None) -> list[Diagnostic]:
    """Respell a tree file in place, comments kept, and return what is left to its author; `name` is its name in messages.

    Declarations of keys go where only the type is declared and the type follows from the key's writer. A file that is no tree,
    or one of the present form, stays as it is.

    Raises
    ------
    FileError
        The file cannot be read, or is not YAML.
    InvalidInput
        It cannot be written.
    """
    name = name or str(path)
    text = read_text(path, name)
    if not _is_tree(parse(text, name)):
        return []
    found = respell(text, name)
    new = quoted_texts(found.text, path)
    if not found.left:
        new = _undeclared(new, path)
    if new == text:
        return found.left
    _write(path, new)
    return [*found.left, *texts_read_as_names(new, path, name)]


def _is_tree(root: Value) -> bool:
    given = root.get("format") if isinstance(root, Map) else None
    return isinstance(given, Scalar) and given.text == FORMAT


def _write(path: Path, text: str) -> None:
    """Write a file anew; one that cannot be written whole stays as it is."""
    target = path.resolve()
    new = target.with_name(f".{target.name}.new")
    try:
        new.write_text(text, encoding="utf-8", newline="")
        copymode(target, new)
        new.replace(target)
    except OSError as error:
        with suppress(OSError):
            new.unlink(missing_ok=True)
        raise InvalidInput(
            f"{path}: the file cannot be written ({error.strerror}); nothing in it was changed"
        ) from error


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
    """Yield the keys of the file that are declared with their type alone, without a comment and an anchor."""
    for mapping in _keys(yaml.compose(text, Loader=yaml.SafeLoader)):
        for key, value in mapping.value:
            if _is_bare(text, key, value):
                yield key.value


def _is_bare(text: str, key: yaml.ScalarNode, value: yaml.Node) -> bool:
    """Whether a declaration says a type and nothing else, as `name: Type` or as `name: {type: Type}`."""
    fields = [field.value for field, _ in value.value] if isinstance(value, yaml.MappingNode) else []
    start, end = key.start_mark.index, value.end_mark.index  # of an alias, the end of its anchor
    is_bare = isinstance(value, yaml.ScalarNode) or fields == ["type"]
    return is_bare and end > start and "&" not in text[start:end] and "#" not in text[start : text.find("\n", end)]


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
            if key.value == name and _is_bare(text, key, value):
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
    last = len(text[:last].rstrip())  # a block ends where the next word begins
    first, end = text.rfind("\n", 0, heading) + 1, text.find("\n", last)
    return text[:first] + ("" if end < 0 else text[end + 1 :])
