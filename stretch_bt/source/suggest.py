"""What the author may have meant: the closest known word, or what else to write."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from stretch_bt.source.values import Scalar, Value

__all__ = ["closest", "did_you_mean", "unknown_key"]

#: characters of a word that is compared with others, which takes the square of its length
_LONGEST = 200


def closest(word: str, known: Iterable[str], alike: float = 0.6) -> str | None:
    """Return the known word that is most like this one, at least so much, from 0 to 1, or None."""
    if len(word) > _LONGEST:
        return None
    known = [k for k in known if len(k) <= _LONGEST]
    folded = {k.lower(): k for k in known}
    match = difflib.get_close_matches(word.lower(), folded, n=1, cutoff=alike)
    return folded[match[0]] if match else None


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return a suggestion: the closest known word, or all of them when few, or nothing."""
    known = sorted(known)
    match = closest(word, known)
    if match is not None:
        return f"did you mean {match!r}?"
    return f"known here: {', '.join(known)}" if 0 < len(known) <= 24 else ""


def unknown_key(key: Scalar, value: Value, known: Iterable[str]) -> str:
    """Return a suggestion for a key that is not known; `{doc: a, b c}` makes one of what a comma cut off."""
    known = list(known)
    cut_off = isinstance(value, Scalar) and not value.quoted and not value.text and not key.quoted
    if cut_off and closest(key.text, known) is None:
        return "put quotes around the text before it if the comma belongs to it, or give it a value"
    return did_you_mean(key.text, known)
