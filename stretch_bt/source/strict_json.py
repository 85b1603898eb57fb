"""JSON of files from anybody: a value nested too deeply, or one that is no number, is refused like any other mistake."""

from __future__ import annotations

import json
import math
from typing import Any

from stretch_bt.errors import InvalidInput

__all__ = ["no_number", "read_json"]


def read_json(text: str | bytes) -> Any:
    """Return the value of a JSON text; raises InvalidInput where it is none, is nested too deeply, or has a number that is not finite."""
    try:
        return json.loads(text, parse_constant=no_number, parse_float=_finite, parse_int=_whole)
    except RecursionError:
        raise InvalidInput("it is JSON nested too deeply to be read") from None
    except ValueError as error:
        raise InvalidInput(f"it is no JSON: {error}") from None


def no_number(name: str) -> float:
    """Refuse NaN and infinity, which Python's JSON takes, as its `parse_constant`."""
    raise ValueError(f"{name} is no number")


def _finite(text: str) -> float:
    value = float(text)
    return value if math.isfinite(value) else no_number(text)


def _whole(text: str) -> int:
    if not math.isfinite(float(text)):
        no_number(f"{text[:8]}... of {len(text)} digits")
    return int(text)
