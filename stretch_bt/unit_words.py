"""Words that people write for units."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

__all__ = ["units_like"]

_WORDS_FOR_UNITS = {
    "sec": "s",
    "msec": "ms",
    "second": "s",
    "minute": "min",
    "hour": "h",
    "meter": "m",
    "metre": "m",
    "millimeter": "mm",
    "millimetre": "mm",
    "centimeter": "cm",
    "centimetre": "cm",
    "micron": "um",
    "newton": "N",
    "pascal": "Pa",
    "kilopascal": "kPa",
    "degree": "deg",
    "°": "deg",
    "radian": "rad",
    "hertz": "Hz",
    "gram": "g",
    "kilogram": "kg",
}


def units_like(word: str, known: Iterable[str]) -> list[str]:
    """Return the units that a word may mean: one that it spells out, and known ones of other case."""
    spelt = get_close_matches(word.lower().removesuffix("s") or word, _WORDS_FOR_UNITS, n=1, cutoff=0.85)
    alike = [name for name in known if name.lower() == word.lower()]
    return [*(_WORDS_FOR_UNITS[name] for name in spelt), *alike]
