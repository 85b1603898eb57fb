"""Text that a device sends, made fit for messages: a terminal obeys control characters, whoever they come from."""

from __future__ import annotations

__all__ = ["device_text"]

#: longer texts are no answer to anything that is asked
_LONGEST = 200


def device_text(data: bytes) -> str:
    r"""Return text on one line, without spaces around it; a character that cannot be printed is written as its escape.

    >>> device_text(b"ready\x1b[2J ")
    'ready\\x1b[2J'
    """
    text = data.decode("utf-8", "backslashreplace").strip()
    told = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
    return told if len(told) <= _LONGEST else f"{told[:_LONGEST]}..."
