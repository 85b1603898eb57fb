"""Fitting a file to a pydantic model, with every mistake at its place."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

from stretch_bt.errors import Diagnostic, FileError
from stretch_bt.source.plain_words import in_words
from stretch_bt.source.schema import field_names, may_be_left_out, sample
from stretch_bt.source.suggest import closest, few_suggestions, unknown_key
from stretch_bt.source.values import TRUTHS, Map, Scalar, Seq, Value, is_nothing, told

__all__ = ["FILE_KINDS", "validate"]

M = TypeVar("M")
#: kinds of files, by the beginning of their formats
FILE_KINDS = {
    "stretch-tree": "tree",
    "stretch-scene": "scene",
    "stretch-cell": "cell",
    "stretch-mocks": "mocks file",
    "stretch-sweep": "sweep",
}


@few_suggestions()
def validate(model: type[M], value: Value) -> M:
    """Fit a value to a pydantic model; raises FileError with every mistake at its place."""
    from pydantic import TypeAdapter, ValidationError

    try:
        made = TypeAdapter(model).validate_python(value.plain())
    except ValidationError as error:
        found = error.errors(include_url=False)
        _check_kind(value, found)
        missing = [e for e in found if e["type"] == "missing"]
        for e in found:  # a misspelt key is also missing under its right name
            if e["type"] == "extra_forbidden":
                beside = [m for m in missing if m["loc"][:-1] == e["loc"][:-1]]
                meant = closest(str(e["loc"][-1]), [str(m["loc"][-1]) for m in beside])
                found = found if meant is None else [m for m in found if m not in beside or m["loc"][-1] != meant]
        raise FileError([_explain(model, value, e) for e in found]) from None
    empty = list(_empty(model, value))
    if empty:
        raise FileError(empty)
    return made


def _empty(model: type, value: Value, path: tuple[str | int, ...] = ()) -> Iterator[Diagnostic]:
    """Yield each key of the model with nothing behind it, which pydantic takes for its default where that is none."""
    inner = value.pairs if isinstance(value, Map) else enumerate(value.items) if isinstance(value, Seq) else ()
    for key, item in inner:
        step = key.text if isinstance(key, Scalar) else key
        if not is_nothing(item):
            yield from _empty(model, item, (*path, step))
        elif step in field_names(model, path):
            yield _nothing(model, item, (*path, step), [*map(str, path), str(step)])


def _check_kind(root: Value, errors: Sequence[Any]) -> None:
    """Refuse a file of another kind by that alone: none of its keys is one of the kind that is wanted."""
    wrong = next((e for e in errors if e["loc"] == ("format",) and e["type"] == "literal_error"), None)
    given = root.get("format") if isinstance(root, Map) else None
    if wrong is None or not isinstance(given, Scalar):
        return
    wanted = wrong["ctx"]["expected"].strip("'")
    kind, here = given.text.partition("/")[0], wanted.partition("/")[0].removeprefix("stretch-")
    if kind in FILE_KINDS and kind != f"stretch-{here}":
        what = f"this is a {FILE_KINDS[kind]}, and a {here} is wanted"
        raise FileError([given.mark.error("format-unknown", what, f"name a file that begins with 'format: {wanted}'")])


def _explain(model: type, root: Value, error: Any) -> Diagnostic:
    """Turn one pydantic error into a diagnostic at the place it speaks of."""
    value, path = _locate(root, error["loc"])
    where = ".".join(path)
    kind = error["type"]
    if kind == "extra_forbidden":
        parent, _ = _locate(root, error["loc"][:-1])
        key = str(error["loc"][-1])
        mark = parent.key(key).mark if isinstance(parent, Map) and key in parent else value.mark
        beside = parent if isinstance(parent, Map) else None
        hint = unknown_key(Scalar(key, False, mark), value, field_names(model, error["loc"][:-1]), beside)
        return mark.error("key-unknown", f"unknown key {key!r}", hint)
    if kind == "missing":
        return value.mark.error("key-missing", f"{where} is missing", f"add '{error['loc'][-1]}: ...'")
    if is_nothing(value) and path:
        return _nothing(model, value, error["loc"], path)
    if kind == "union_tag_not_found" or kind == "union_tag_invalid":
        return _wrong_tag(model, value, error, where)
    if kind == "model_attributes_type" and isinstance(value, Scalar):
        return value.mark.error(
            "value", f"{where} takes a mapping, not {value.text!r}", f"write '{{type: {value.text}}}'"
        )
    if kind == "string_too_short" and error["ctx"]["min_length"] == 1:
        return value.mark.error("value", f"{where} is empty", "write what it names, or leave it out")
    said, hint = in_words(error, told(value))
    return value.mark.error("value", (where + said).removeprefix(": "), _by_spelling(value, kind) or hint)


def _nothing(model: type, value: Value, loc: Sequence[str | int], path: Sequence[str]) -> Diagnostic:
    """Return what is said of a key or an entry with nothing behind it."""
    name = path[-1]
    loc = loc if str(loc[-1]) == name else loc[:-1]  # of an only entry that stands for its list
    example = sample(model, loc)
    if isinstance(loc[-1], int):
        return value.mark.error("value", f"{'.'.join(path)} is empty", "write a value, or take the entry out")
    what = f"write '{name}: {example}'" if example else "write its value behind it"
    left_out = ", or leave it out" if may_be_left_out(model, loc) else ""
    return value.mark.error("value", f"{'.'.join(path)} is empty", what + left_out)


def _wrong_tag(model: type, value: Value, error: Any, where: str) -> Diagnostic:
    """Return the diagnostic of a mapping whose kind is missing or unknown, at the place of the kind where there is one."""
    tag = str(error["ctx"]["discriminator"]).strip("'")
    given = value.get(tag) if isinstance(value, Map) else None
    if given is None:
        return value.mark.error("key-missing", f"{where}.{tag} is missing", f"add '{tag}: ...'")
    if is_nothing(given):
        return _nothing(model, given, (*error["loc"], tag), (*where.split("."), tag))
    said, hint = in_words(error, told(given))
    return given.mark.error("value", f"{where}.{tag}{said}", hint)


def _by_spelling(value: Value, kind: str) -> str:
    """Return what to write where the value is right and its spelling wrong, or nothing."""
    if not isinstance(value, Scalar):
        return ""
    if kind.startswith("bool") and value.text.lower() in TRUTHS:
        return f"write '{TRUTHS[value.text.lower()]}'"
    if kind.startswith("string_t"):
        return "put quotes around it"
    number = kind.startswith(("bool", "int", "float", "model_", "dict", "list", "tuple"))
    return (
        "remove the quotes"
        if number and value.quoted and Scalar(value.text, False, value.mark).value != value.text
        else ""
    )


def _locate(root: Value, loc: Sequence[str | int]) -> tuple[Value, list[str]]:
    """Follow a pydantic location as far as the file goes; tags of unions are passed over."""
    value, path = root, []
    for step in loc:
        if isinstance(value, Map) and str(step) in value:
            value = value.get(str(step)) or value
            path.append(str(step))
        elif isinstance(value, Seq) and isinstance(step, int) and step < len(value.items):
            value = value.items[step]
            path.append(str(step))
        elif step is loc[-1] and isinstance(value, Map):
            path.append(str(step))
    return value, path
