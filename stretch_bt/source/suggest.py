"""What the author may have meant: the closest known word, or what else to write."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from stretch_bt.source.values import Map, Scalar, Value

__all__ = ["MISSPELT", "closest", "did_you_mean", "few_suggestions", "stands_already", "unknown_key"]

#: characters of a word that is compared with others, which takes the square of its length
_LONGEST = 200
#: pairs of characters that one check compares, a quarter of a second of them; a mistake among 150 names takes 20,000
MOST = 1_500_000
#: how like a known word, 0 to 1, a name is that is taken for a slip where other names are right, too
MISSPELT = 0.8
#: known words that a suggestion lists in full
_FEW = 24

#: pairs of characters that the present check may still compare
_left: ContextVar[list[int] | None] = ContextVar("left", default=None)


@contextmanager
def few_suggestions() -> Iterator[None]:
    """Compare no more inside than a person waits for; a block inside another one shares its bound.

    A file with thousands of mistakes and of names would take the product of both: its later mistakes get no suggestion.
    """
    if _left.get() is not None:
        yield
        return
    before = _left.set([MOST])
    try:
        yield
    finally:
        _left.reset(before)


def _spent() -> bool:
    left = _left.get()
    return left is not None and left[0] == 0


def _may_compare(pairs: int) -> bool:
    """Take this many pairs of characters from the remaining ones; where those are too few, none remain."""
    left = _left.get() or [MOST]
    enough = pairs <= left[0]
    left[0] = left[0] - pairs if enough else 0
    return enough


def closest(word: str, known: Iterable[str], alike: float = 0.6) -> str | None:
    """Return the known word that is most like this one, at least so much, from 0 to 1, or None."""
    if len(word) > _LONGEST or _spent():
        return None
    folded = {k.lower(): k for k in known if len(k) <= _LONGEST}
    if not _may_compare(len(word) * sum(map(len, folded))):
        return None
    match = difflib.get_close_matches(word.lower(), folded, n=1, cutoff=alike)
    return folded[match[0]] if match else None


def did_you_mean(word: str, known: Iterable[str], prefix: str = "") -> str:
    """Return a suggestion: the closest known word, or all of them when few, or nothing; each stands behind the prefix, which is right."""
    if _spent() and isinstance(known, Collection) and len(known) > _FEW:
        return ""
    known = sorted(known)
    match = closest(word, known)
    if match is not None:
        return f"did you mean {prefix + match!r}?"
    return f"known here: {', '.join(prefix + word for word in known)}" if 0 < len(known) <= _FEW else ""


def unknown_key(key: Scalar, value: Value, known: Iterable[str], beside: Map | None = None) -> str:
    """Return a suggestion for a key that is not known, `beside` others; `{doc: a, b c}` makes one of what a comma cut off."""
    known = known if isinstance(known, Collection) else list(known)
    cut_off = isinstance(value, Scalar) and not value.quoted and not value.text and not key.quoted
    if cut_off and closest(key.text, known) is None:
        return "put quotes around the text before it if the comma belongs to it, or give it a value"
    if beside is not None and (meant := closest(key.text, known)) is not None and meant in beside:
        return stands_already(meant)
    return did_you_mean(key.text, known)


def stands_already(name: str) -> str:
    """Return what to do about a second spelling of a key that is there."""
    return f"{name!r} stands there already; remove one of them"
