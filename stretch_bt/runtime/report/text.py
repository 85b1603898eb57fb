"""Text for people: numbers with their error, and HTML from any content."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence
from typing import Any

from stretch_bt.plain_numbers import is_number

__all__ = ["escape", "number", "seconds", "section", "table", "with_sd"]

_MOST_DECIMALS = 12  # past these a number is shown by its power of ten
_MOST_DIGITS = 15  # that a float has


def escape(content: object) -> str:
    """Return content as HTML text, which attributes take too."""
    return html.escape(str(content))


def number(value: Any, digits: int = 4) -> str:
    """Return a float with so many significant digits; anything else as it is."""
    if not isinstance(value, float):
        return "–" if value is None else str(value)
    return f"{value:.{digits}g}".replace("-", "−")


def with_sd(value: Any, sd: Any) -> str:
    """Return `value ± sd`, the sd with two digits and the value to the same decimal place."""
    if not (is_number(value) and is_number(sd)) or sd <= 0:
        return number(value)
    decimals = 1 - math.floor(math.log10(sd))
    if abs(decimals) > _MOST_DECIMALS:
        digits = min(max(decimals + math.floor(math.log10(abs(value))), 0), _MOST_DIGITS) if value else 1
        return f"{value:.{digits}e} ± {sd:.1e}".replace("-", "−")
    shown = (f"{round(v, decimals):.{max(decimals, 0)}f}" for v in (value, sd))
    return " ± ".join(shown).replace("-", "−")


def seconds(time: Any) -> str:
    """Return a time, s, to the millisecond, below 1 s in four digits; None as a dash."""
    if not is_number(time) or abs(time) < 1:
        return number(time)
    return f"{time:.3f}".rstrip("0").rstrip(".").replace("-", "−")


def table(head: Sequence[str], rows: Iterable[Sequence[str]], numeric: Sequence[int] = ()) -> str:
    """Return an HTML table; cells are HTML, the columns named in `numeric` are aligned right."""
    kinds = [' class="n"' if i in numeric else "" for i in range(len(head))]
    top = "".join(f"<th{kind}>{name}</th>" for kind, name in zip(kinds, head, strict=True))
    body = "".join(
        "<tr>" + "".join(f"<td{kind}>{cell}</td>" for kind, cell in zip(kinds, row, strict=True)) + "</tr>"
        for row in rows
    )
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def section(title: str, content: str, note: str = "") -> str:
    """Return a section of the page, or nothing where there is no content."""
    if not content:
        return ""
    extra = f'<p class="note">{note}</p>' if note else ""
    return f"<section><h2>{title}</h2>{extra}{content}</section>"
