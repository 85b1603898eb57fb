"""Any value as JSON that is the same for equal values: numbers by repr, arrays by their digest, never a NaN literal."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np

from stretch_bt.units import Estimate

__all__ = ["dumps", "plain"]

MAX_DEPTH = 12
#: at most so many numbers of an array are looked at
_SAMPLED = 8192
#: into how many parts the largest number of an array is divided for their sum
_PARTS = 2.0**30
_SMALLEST = 1e-300
#: weights are whole parts of 2^16; the odd factor gives neighbours weights that lie far apart, and none is zero
_WEIGHTS = (np.arange(1, _SAMPLED + 2, dtype=np.int64) * 40503) % 65536

_ENCODER = json.JSONEncoder(sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def dumps(value: Any) -> bytes:
    """Return a plain value as one line of compact JSON with sorted keys, in UTF-8."""
    # A lone surrogate has no UTF-8; its backslash form is the JSON escape of it.
    return _ENCODER.encode(value).encode("utf-8", "backslashreplace")


def plain(value: Any, depth: int = MAX_DEPTH) -> Any:
    """Return a value as JSON's own types.

    Dataclasses become their fields, enums their values, arrays `{"shape", "dtype", "sha256"}` with 16 hex digits, arrays of
    floats with `{"finite", "largest", "mean", "weighted"}` too, and numbers that JSON lacks the strings "NaN", "Infinity" and
    "-Infinity". Anything else becomes `{"type": its name}`.
    """
    kind = value.__class__
    if kind is str or kind is int or kind is bool or value is None:
        return value
    if kind is float:
        return value if math.isfinite(value) else _name_of(value)
    if depth == 0:
        return {"type": kind.__qualname__}
    return _compound(value, depth - 1)


def _name_of(value: float) -> str:
    if math.isnan(value):
        return "NaN"
    return "Infinity" if value > 0 else "-Infinity"


def _compound(value: Any, depth: int) -> Any:
    if isinstance(value, Enum):
        return plain(value.value, depth)
    if isinstance(value, Estimate):
        return {"value": plain(float(value), depth), "sd": plain(value.sd, depth)}
    if isinstance(value, str | int | float | np.generic):
        return _number_or_text(value)
    if isinstance(value, np.ndarray):
        return _array(value)
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name, None), depth) for f in fields(value)}
    if isinstance(value, Mapping):
        return {str(plain(key, depth)): plain(item, depth) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, depth) for item in value]
    if isinstance(value, set | frozenset):
        return sorted((plain(item, depth) for item in value), key=dumps)
    return {"type": type(value).__qualname__}


def _number_or_text(value: Any) -> Any:
    if isinstance(value, str):
        return str(value)
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return plain(float(value))
    return str(value)


def _array(array: np.ndarray[Any, Any]) -> Any:
    summary: dict[str, Any] = {"shape": list(array.shape), "dtype": str(array.dtype)}
    if not array.dtype.hasobject:  # the bytes of an object array are addresses
        summary["sha256"] = hashlib.sha256(array.tobytes()).hexdigest()[:16]
    if array.dtype.kind == "f":
        summary.update(_sizes(array))
    return summary


def _sizes(array: np.ndarray[Any, Any]) -> dict[str, float]:
    """Return how many of some numbers of an array are finite, their largest and mean magnitude, and a weighted mean with signs.

    Two arrays that differ in last digits agree in these; signs and order show in the weighted mean, whose weights, from 0 to 1,
    follow from the places. Whole numbers are summed, so that no processor changes the sum.
    """
    some = array.reshape(-1)[:: array.size // _SAMPLED + 1].astype(float)
    known = np.isfinite(some)
    weights, some = _WEIGHTS[: some.size][known], some[known]
    largest = float(np.abs(some).max(initial=0.0))
    if largest < _SMALLEST:
        return {"finite": some.size, "largest": largest, "mean": 0.0, "weighted": 0.0}
    parts = np.rint(some / largest * _PARTS).astype(np.int64)
    mean, weighted = (largest * (int(total) / some.size / _PARTS) for total in (np.abs(parts).sum(), weights @ parts))
    return {"finite": some.size, "largest": largest, "mean": mean, "weighted": weighted / 65536}
