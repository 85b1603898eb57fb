"""Text for people: numbers with their error, and HTML from any content."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence
from typing import Any

__all__ = ["escape", "number", "section", "table", "with_sd"]


def escape(content: object) -> str:
    """Return content as HTML text, which attributes take too."""
    return html.escape(str(content))


def number(value: Any, digits: int = 4) -> str:
    """Return a float with so many significant digits; anything else as it is."""
    if not isinstance(value, float):
        return "–" if value is None else str(value)
    return f"{value:.{digits}g}".replace("-", "−")


def with_sd(value: Any, sd: Any) -> str:
    """Return `value ± sd`, the sd with two digits and the value with as many decimals."""
    numeric = all(isinstance(v, int | float) and math.isfinite(v) for v in (value, sd))
    if not numeric or sd <= 0:
        return number(value)
    decimals = 1 - math.floor(math.log10(sd))
    if not 0 <= decimals <= 6:
        return f"{number(value)} ± {number(sd, 2)}"
    return f"{value:.{decimals}f} ± {sd:.{decimals}f}".replace("-", "−")


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
