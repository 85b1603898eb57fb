"""Text made safe for XML, HTML and Graphviz."""

from __future__ import annotations

import html
import re

__all__ = ["clean", "dot", "xml"]

_FORBIDDEN = re.compile(r"[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def clean(text: str) -> str:
    """Return text without the characters that XML forbids."""
    return _FORBIDDEN.sub("\ufffd", text)


def xml(text: object) -> str:
    """Return text for an element or an attribute."""
    return html.escape(clean(str(text)), quote=True)


def dot(text: object) -> str:
    """Return text for a quoted string of Graphviz."""
    return clean(str(text)).replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ")
