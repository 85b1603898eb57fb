"""What is wrong where the YAML parser gives up, in the words of somebody who writes a file."""

from __future__ import annotations

import re

import yaml

__all__ = ["explain_syntax", "lines_of"]

_BREAK = re.compile(r"\r\n|[\n\r\x85\u2028\u2029]")


def lines_of(text: str) -> list[str]:
    """Return the lines of a text as the YAML parser counts them, without their ends."""
    return _BREAK.split(text)


def explain_syntax(text: str, error: yaml.MarkedYAMLError) -> tuple[yaml.Mark | None, str, str]:
    """Return the place, the message and the hint for a mistake that the YAML parser found."""
    context, problem = error.context or "", error.problem or ""
    place = error.problem_mark or error.context_mark
    lines = lines_of(text)
    row = lines[place.line] if place is not None and place.line < len(lines) else ""
    if "scanning an a" in context or "stream" in problem:  # an alias, an anchor, or a quote that is never closed
        place = error.context_mark or place
    message = f"this is not YAML: {' '.join(part for part in (context, problem) if part)}"
    if (
        ("flow mapping" in context or "flow sequence" in context)
        and error.context_mark is not None
        and place is not None
    ):
        return _open_bracket(lines, error.context_mark, place, row)
    if place is not None and "\t" in row[: place.column + 1]:
        return place, "this is not YAML: a tab is used for indentation", "indent with spaces, not tabs"
    if "quoted scalar" in context and "stream" in problem:
        return place, "this is not YAML: the quote that opens here is never closed", "close the quote"
    if "unexpected ':'" in problem:
        return place, "this is not YAML: no space follows the colon", "put a space after the colon, and then the value"
    if (
        "did not find expected key" in problem
        and place is not None
        and row[: place.column].rstrip().endswith(('"', "'"))
    ):
        return (
            place,
            "this is not YAML: text goes on after a closing quote",
            "put quotes of the other kind around the whole of it",
        )
    if "did not find expected key" in problem:
        hint = "indent it like the keys around it, and close brackets and quotes before it"
        return place, "this is not YAML: this line does not go on where the one before ends", hint
    if "mapping values" in problem and place is not None:
        return place, *_stray_colon(row[: place.column])
    if place is not None and row[place.column : place.column + 1] in tuple("*&!|>%@`"):
        quote = "put quotes around text that begins with a special character"
        return place, f"this is not YAML: text cannot begin with {row[place.column]!r}", quote
    return place, message, "check indentation, brackets and quotes on this line and the one before"


def _stray_colon(before: str) -> tuple[str, str]:
    if ": " in before:
        return "this is not YAML: a second ': ' on one line", "put quotes around text that holds ': '"
    return (
        "this is not YAML: a key is not expected here",
        "indent it like the keys around it, or add ':' to the line above",
    )


def _open_bracket(lines: list[str], opened: yaml.Mark, place: yaml.Mark, row: str) -> tuple[yaml.Mark, str, str]:
    bracket = lines[opened.line][opened.column : opened.column + 1]
    closing = {"{": "}", "[": "]"}.get(bracket, bracket)
    before, after = row[: place.column], row[place.column :]
    word = re.search(r"[^\s,{[:]+$", before)
    if word and after.startswith("["):
        number = re.match(r"\[\s*(\d+)\s*\]", after)
        hint = f"put quotes around '{word[0]}{number[0] if number else '[...]'}'"
        if word[0].startswith("$"):
            hint = f"write '{word[0]}.{number[1] if number else 0}' to take an item"
        return place, "this is not YAML: a bracket is not expected here", hint
    if not "".join(lines[place.line :])[place.column :].strip() or place.line > opened.line:
        message = f"this is not YAML: the {bracket!r} that opens here is not closed"
        return opened, message, f"add {closing!r} where it ends"
    message = f"this is not YAML: ',' or {closing!r} is missing here"
    return place, message, f"add {closing!r}, or put quotes around text that holds a bracket, brace or comma"
