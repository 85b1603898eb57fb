"""Values of params: what the command line, a caller from Python or a scene sets in place of a default."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stretch_bt.errors import FileError
from stretch_bt.plain_numbers import plain_list, plain_number
from stretch_bt.source import Map, Mark, Scalar, Value, did_you_mean, parse
from stretch_bt.tree.document import Document, Param
from stretch_bt.tree.renamed import renamed
from stretch_bt.tree.types import ANY, Family, Type
from stretch_bt.tree.values import ValueRefused, check_bounds, example, literal

__all__ = ["set_params"]


def set_params(doc: Document, overrides: Mapping[str, Any]) -> None:
    """Give the params of a file the values that are set; notes what does not fit, and params without a value."""
    for name, given in overrides.items():
        prefix, _, rest = name.partition(".")
        if not (rest and prefix in doc.imports):
            _set(doc, name, given)
    for param in doc.params.values():
        if param.value is None and not param.has_default and param.type is not ANY and param.name not in overrides:
            hint = f"give it a default, or --set {doc.prefix}{param.name}=..."
            found = param.mark.error("param-missing", f"param {param.name!r} has no value", hint)
            doc.diagnostics.append(found)


def _set(doc: Document, name: str, given: Any) -> None:
    text: Any = given.text if isinstance(given, Scalar) else given
    mark = Mark("--set", 1, len(doc.prefix) + len(name) + 2, len(str(text)) or 1)
    if isinstance(given, Scalar):  # of a scene
        mark = given.mark
    param = doc.params.get(name)
    if param is None:
        _unknown(doc, name)
        return
    try:
        _take(param, text, name, mark)
    except ValueRefused as refused:
        doc.diagnostics.append(refused.diagnostic)
    except FileError:
        message = f"{name} takes {param.type}, not {text!r}"
        doc.diagnostics.append(mark.error("type-mismatch", message, example(param.type)))


def _take(param: Param, text: Any, name: str, mark: Mark) -> None:
    is_none = text is None or (isinstance(text, str) and text == "none")
    if is_none and param.has_default and param.default is None and param.type.family is not Family.STR:
        param.value = None
        return
    value = literal(_given(text, param.type, mark), param.type, name)
    check_bounds(value, param.type, param.min, param.max, mark, name)
    param.value = value  # one that is refused reaches no port, which would refuse it again


def _unknown(doc: Document, name: str) -> None:
    full = doc.prefix + name
    within = [*doc.params, *(f"{p}.{n}" for p, d in doc.imports.items() for n in d.params)]
    now = renamed(Path(doc.file).stem, name)
    hint = f"it is called {now!r} now: write '--set {doc.prefix}{now}=...'" if now else ""
    hint = hint or did_you_mean(name, within, doc.prefix)
    at, message = Mark("--set", 1, 1, len(full)), f"there is no param {full!r}"
    doc.diagnostics.append(at.error("param-unknown", message, hint or "its file has no params"))


def _given(text: Any, type_: Type, mark: Mark) -> Value:
    """Return a set value as a value of a file; only a list is written in YAML."""
    written = _written(text, type_)
    if type_.family is Family.LIST:
        return _moved(parse(written, "--set"), mark)
    return Scalar(written, type_.family in (Family.STR, Family.ENUM), mark)


def _written(value: Any, type_: Type) -> str:
    """Return a set value as the text in a file; numbers given from Python are SI."""
    value = plain_list(plain_number(value))
    if isinstance(value, str):
        return value
    if isinstance(value, list | tuple):
        return f"[{', '.join(_item(item, type_.item or type_) for item in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):  # numpy and an Estimate write theirs with a name around it
        value = float(value)
    return f"{value!r} {type_.kind.si_unit}" if type_.kind else str(value)


def _item(value: Any, type_: Type) -> str:
    """Return an item of a list as the text in a file; a text keeps its commas and brackets."""
    if isinstance(value, str) and type_.family is Family.STR:
        return json.dumps(value, ensure_ascii=False)
    return _written(value, type_)


def _moved(value: Value, mark: Mark) -> Value:
    """Return a value of the command line with its place there."""
    if isinstance(value, Scalar):
        return Scalar(value.text, value.quoted, mark)
    if isinstance(value, Map):
        return Map(value.pairs, mark)
    return type(value)(tuple(_moved(item, mark) for item in value.items), mark)
