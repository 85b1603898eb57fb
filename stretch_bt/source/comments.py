"""Comments beside the fields of a class, which document them."""

from __future__ import annotations

import inspect
import io
import tokenize
from functools import cache

__all__ = ["comments_of"]


@cache
def comments_of(cls: type) -> dict[str, str]:
    """Return the comment on the line of each annotated attribute, where the source can be read; no run needs to."""
    try:
        source = inspect.getsource(cls)
    except (OSError, TypeError):
        return {}
    found: dict[str, str] = {}
    first_name = ""
    fresh_line = True
    for token in tokenize.generate_tokens(io.StringIO(inspect.cleandoc(source)).readline):
        if token.type in (tokenize.NEWLINE, tokenize.NL, tokenize.INDENT, tokenize.DEDENT):
            fresh_line = True
        elif token.type == tokenize.COMMENT and first_name and not fresh_line:
            found[first_name] = token.string.lstrip("# ").strip()
        elif fresh_line:
            first_name = token.string if token.type == tokenize.NAME else ""
            fresh_line = False
    return found
