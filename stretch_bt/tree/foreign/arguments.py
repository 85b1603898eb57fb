"""The constructor arguments of a class of behaviours: those that a tree file can give, and those that it cannot."""

from __future__ import annotations

import inspect
import re
import typing
from dataclasses import dataclass
from enum import Enum
from types import SimpleNamespace
from typing import Any

from stretch_bt.tree.foreign.refused import BehaviourRefused
from stretch_bt.tree.foreign.written import Written, written_as

__all__ = ["Argument", "arguments_of", "takes_name"]

#: arguments that a place in a tree gives, and that py_trees' ports take for their XML
_GIVEN = ("name", "behaviour_class_name")
_NAMED = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
_VARIABLE = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
#: one argument in the docstring of a class, as Google's style has it: `duration: length of time (s)`
_TOLD = re.compile(r"^\s+(\w+)(?: \([^)]*\))?:\s+(\S.*(?:\n(?!\s+\w+(?: \([^)]*\))?:\s)\s+\S.*)*)", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Argument:
    """One constructor argument; `written` is None where a tree file cannot write it, `default` is the default of the class."""

    name: str
    annotation: Any
    written: Written | None
    required: bool
    default: Any
    doc: str


def arguments_of(cls: type) -> list[Argument]:
    """Return what the constructor of a class takes besides its name."""
    hints, docs = _hints(cls), _docs(cls)
    found = []
    for parameter in _parameters(cls):
        if parameter.kind in _VARIABLE or parameter.name in _GIVEN:
            continue
        annotation = hints.get(parameter.name, parameter.annotation)
        required = parameter.default is inspect.Parameter.empty
        if annotation is inspect.Parameter.empty and isinstance(parameter.default, bool | int | float | str | Enum):
            annotation = type(parameter.default)
        written = written_as(annotation) if parameter.kind in _NAMED else None
        doc = docs.get(parameter.name, "")
        found.append(Argument(parameter.name, annotation, written, required, parameter.default, doc))
    return found


def takes_name(cls: type) -> bool:
    """Whether the constructor takes the name of the behaviour."""
    kinds = {parameter.name: parameter.kind for parameter in _parameters(cls)}
    return kinds.get("name") in _NAMED or inspect.Parameter.VAR_KEYWORD in kinds.values()


def _parameters(cls: type) -> list[inspect.Parameter]:
    try:
        return list(inspect.signature(cls).parameters.values())
    except (TypeError, ValueError) as error:
        message = f"what {cls.__qualname__} takes cannot be read: {error}"
        raise BehaviourRefused(
            message, "write a subclass with an __init__ of its own, whose arguments have types"
        ) from None


def _hints(cls: type) -> dict[str, Any]:
    """Return the annotations of the constructor; a text that means nothing at run time stays text."""
    made = inspect.unwrap(cls.__init__)  # type: ignore[misc]
    found = {}
    for name, hint in getattr(made, "__annotations__", {}).items():
        one = SimpleNamespace(__annotations__={name: hint})
        try:
            known = typing.get_type_hints(one, getattr(made, "__globals__", {}), include_extras=True)
        except Exception:  # a name that only a type checker imports, or whatever else stands there
            known = {name: hint}
        found[name] = known[name]
    return found


def _docs(cls: type) -> dict[str, str]:
    """Return what the docstrings of a class and of its constructor say of each argument."""
    texts = (inspect.getdoc(cls.__init__) or "", inspect.getdoc(cls) or "")  # type: ignore[misc]
    found: dict[str, str] = {}
    for text in texts:
        section = re.search(r"^Arg(?:ument)?s:\n((?:[ \t]+\S.*\n?|\n(?=[ \t]))+)", text, re.MULTILINE)
        for told in _TOLD.finditer(section[1] if section else ""):
            found.setdefault(told[1], " ".join(told[2].split()))
    return found
