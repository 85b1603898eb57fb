"""What pydantic finds wrong with a value, in the words of this package."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from stretch_bt.source.suggest import did_you_mean

__all__ = ["in_words"]

#: by the beginning of the type of an error: the wanted value, and an example
_WANTED = {
    "bool": ("true or false", "true"),
    "int": ("a whole number", "3"),
    "float": ("a number", "0.5"),
    "decimal": ("a number", "0.5"),
    "finite_number": ("a finite number", "0.5"),
    "string_t": ("text", "'text'"),
    "string_sub_type": ("text", "'text'"),
    "path": ("the path of a file", "'folder/file'"),
    "model_": ("a mapping", "{name: value}"),
    "dataclass": ("a mapping", "{name: value}"),
    "mapping": ("a mapping", "{name: value}"),
    "dict": ("a mapping", "{name: value}"),
    "list": ("a list", "[value]"),
    "tuple": ("a list", "[value]"),
    "set": ("a list", "[value]"),
    "frozen_set": ("a list", "[value]"),
    "iterable": ("a list", "[value]"),
}
#: by the type of an error: the word before its bound, and the name of the bound
_BOUNDS = {
    "greater_than": ("more than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
    "multiple_of": ("a multiple of", "multiple_of"),
}
_ENTRIES = {"too_short": ("at least", "min_length"), "too_long": ("at most", "max_length")}
_LETTERS = {"string_too_short": ("at least", "min_length"), "string_too_long": ("at most", "max_length")}


def in_words(error: Mapping[str, Any], given: str) -> tuple[str, str]:
    """Return what is said of one error of pydantic after the name of the place, and what to write instead.

    `given` is the value as the user knows it; the first text begins with a colon where it is a sentence of its own.
    """
    kind, context = str(error["type"]), error.get("ctx", {})
    if kind in _BOUNDS:
        word, name = _BOUNDS[kind]
        return f": {error['input']} is out of bounds", f"write {word} {context[name]}"
    if kind in _ENTRIES:
        return _counted(_ENTRIES[kind], context, context["actual_length"], ("entry", "entries"))
    if kind in _LETTERS:
        return _counted(_LETTERS[kind], context, given, ("character", "characters"))
    if kind == "string_pattern_mismatch":
        return f" does not take {given}", f"write text of the form {context['pattern']}"
    if kind in ("literal_error", "enum", "union_tag_invalid"):
        return _one_of(str(context.get("expected") or context.get("expected_tags")), error, given)
    wanted = next((what for start, what in _WANTED.items() if kind.startswith(start)), None)
    if wanted is not None:
        return f" takes {wanted[0]}, not {given}", f"write {wanted[0]}, as in {wanted[1]}"
    return _own_words(str(error["msg"]), given)


def _counted(
    bound: tuple[str, str], context: Mapping[str, Any], given: object, nouns: tuple[str, str]
) -> tuple[str, str]:
    number = context[bound[1]]
    wanted = f"{bound[0]} {'one' if number == 1 else number} {nouns[number != 1]}"
    return f" takes {wanted}, not {given}", f"write {wanted}"


def _one_of(expected: str, error: Mapping[str, Any], given: str) -> tuple[str, str]:
    """Return the message about a word that is none of the expected ones, and what to write."""
    options = re.findall(r"'([^']*)'", expected)
    word = error.get("ctx", {}).get("tag", error.get("input"))
    meant = did_you_mean(word, options) if isinstance(word, str) else ""
    *most, last = options or [expected]
    listed = f"{', '.join(most)} or {last}" if most else last
    return f" takes {listed}, not {given}", meant if meant.startswith("did") else f"write {listed}"


def _own_words(message: str, given: str) -> tuple[str, str]:
    """Return the message of a validator, and its text after the semicolon, which says what to write; of pydantic's only the wanted type."""
    said = re.match(r"(Value error|Assertion failed), ", message)
    if said is not None:
        message, _, hint = message[said.end() :].partition("; ")
        message = f" {message}" if message.startswith("takes ") else f": {message}"
        return message, hint or "see the schema of this file"
    wanted = re.match(r"Input should be (?:a valid |an? instance of )?(.*)", message, re.DOTALL)
    if wanted is not None:
        return f" takes {wanted[1].partition(', ')[0]}, not {given}", f"write {wanted[1].partition(', ')[0]}"
    of_pydantic = message.startswith(("Input", "Unable to extract tag"))
    return f" does not take {given}" + ("" if of_pydantic else f": {message}"), "see the schema of this file"
