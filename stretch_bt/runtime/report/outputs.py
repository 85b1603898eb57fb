"""The outputs of a run beside what the scene knows of them."""

from __future__ import annotations

from typing import Any

from stretch_bt.plain_numbers import is_number
from stretch_bt.runtime.report.text import escape, number, table, with_sd

__all__ = ["outputs"]

_HEAD = ("output", "value", "unit", "truth", "error", "relative error", "error in sd")


def outputs(result: dict[str, Any]) -> str:
    """Return the table of outputs, with truth and errors where there is any truth."""
    given, truth = result.get("outputs") or {}, result.get("truth") or {}
    if not given:
        return ""
    rows = [_row(name, output, (truth.get(name) or {}).get("value")) for name, output in given.items()]
    width = len(_HEAD) if any(row[3] for row in rows) else 3
    content = table(_HEAD[:width], [row[:width] for row in rows], [i for i in (1, 3, 4, 5, 6) if i < width])
    return f'<div class="outputs">{content}</div>'


def _row(name: str, output: dict[str, Any], true: Any) -> list[str]:
    value, sd = output.get("value"), output.get("sd")
    cells = [escape(name), escape(with_sd(value, sd)), escape(output.get("unit") or "")]
    if true is None:
        return [*cells, "", "", "", ""]
    return [*cells, escape(number(true)), *_errors(value, true, sd)]


def _errors(value: Any, true: Any, sd: Any) -> tuple[str, ...]:
    """Return the error, in the output's unit, relatively and in standard deviations, each empty where it has no meaning."""
    if not (is_number(value) and is_number(true)):
        return "", "", ""
    error = f"{value - true:+.2g}"
    relative = f"{(value - true) / abs(true):+.1%}" if true else ""
    deviation = f"{(value - true) / sd:+.1f}" if is_number(sd) and sd > 0 else ""
    return tuple(text.replace("-", "−") for text in (error, relative, deviation))
