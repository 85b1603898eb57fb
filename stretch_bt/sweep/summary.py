"""What the rows of a sweep say together: how the items ended, what they cost, and each output against the truth."""

from __future__ import annotations

import json
from array import array
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.plain_numbers import is_number

__all__ = ["SUMMARY", "Output", "Summary", "SweepGroup", "can_be_summed_up", "write_summary"]

SUMMARY = "summary.json"
#: reasons that a group lists, the most frequent ones
MOST_REASONS = 5
#: times of an item that are summed up, s
TIMES = ("cpu_seconds", "wall_seconds", "task_seconds")
#: types in JSON of the fields of a row, and of an output in it, that are summed up
_TEXT, _NUMBER = (str,), (int, float)
_FIELDS = {
    "tree": _TEXT,
    "scene": (str, type(None)),
    "set": (dict,),
    "status": _TEXT,
    "reason": _TEXT,
    "outputs": (dict,),
    "truth": (dict,),
    **dict.fromkeys(TIMES, _NUMBER),
}


def can_be_summed_up(row: dict[str, Any]) -> bool:
    """Whether a row, read from JSON, has each field that a summary takes from it, of its type."""
    return (
        _has(row, _FIELDS)
        and all(type(text) is str for text in row["set"].values())
        and all(
            _has(output, {"unit": _TEXT}) and {"value", "sd"} <= output.keys() for output in row["outputs"].values()
        )
        and all(type(truth) is dict for truth in row["truth"].values())
    )


def _has(row: Any, types: dict[str, tuple[type, ...]]) -> bool:
    return type(row) is dict and all(name in row and type(row[name]) in kinds for name, kinds in types.items())


@dataclass(slots=True)
class Output:
    """The values of one output of a group; the deviation and the truth of one that states none, or that no scene knows, are NaN."""

    unit: str
    values: array[float] = field(default_factory=lambda: array("d"))
    sds: array[float] = field(default_factory=lambda: array("d"))
    truths: array[float] = field(default_factory=lambda: array("d"))

    def to_json(self) -> dict[str, Any]:
        """Return mean and spread; where the truth is known bias, rms error, and that over the stated deviation."""
        values, sds, truths = (np.asarray(each, np.float64) for each in (self.values, self.sds, self.truths))
        errors = values - truths
        return {
            "unit": self.unit,
            "count": len(values),
            "mean": float(values.mean()),
            "spread": float(values.std(ddof=1)) if len(values) > 1 else None,
            "stated_sd": _rms(sds),
            "truth": _mean(truths),
            "bias": _mean(errors),
            "rms_error": _rms(errors),
            "error_over_sd": _rms(errors[sds > 0] / sds[sds > 0]),
        }


@dataclass(slots=True)
class SweepGroup:
    """The items of one tree, scene and combination of params."""

    tree: str
    scene: str | None
    params: dict[str, str]
    statuses: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    outputs: dict[str, Output] = field(default_factory=dict)

    def take(self, row: dict[str, Any]) -> None:
        """Take a row; only what came to SUCCESS counts for the outputs."""
        self.statuses[row["status"]] += 1
        if row["status"] != "SUCCESS":
            self.reasons[row["reason"]] += 1
            return
        for name, output in row["outputs"].items():
            if is_number(output["value"]):
                found = self.outputs.setdefault(name, Output(output["unit"]))
                truth = row["truth"].get(name, {}).get("value")
                found.values.append(output["value"])
                found.sds.append(output["sd"] if is_number(output["sd"]) else np.nan)
                found.truths.append(truth if is_number(truth) else np.nan)

    @property
    def name(self) -> str:
        """Text that distinguishes it from the other groups, on one line."""
        return ", ".join(
            [self.tree, *([self.scene] if self.scene else []), *(f"{k}={v}" for k, v in self.params.items())]
        )

    def to_json(self) -> dict[str, Any]:
        """Return its fields for summary.json."""
        return {
            "tree": self.tree,
            "scene": self.scene,
            "set": self.params,
            "items": sum(self.statuses.values()),
            "statuses": dict(sorted(self.statuses.items())),
            "reasons": dict(self.reasons.most_common(MOST_REASONS)),
            "outputs": {name: output.to_json() for name, output in self.outputs.items()},
        }


@dataclass(slots=True)
class Summary:
    """All rows of a sweep; CPU and wall time, s, are the times of the runs, without the start of a worker."""

    items: int
    statuses: Counter[str] = field(default_factory=Counter)
    cpu_seconds: array[float] = field(default_factory=lambda: array("d"))
    wall_seconds: array[float] = field(default_factory=lambda: array("d"))
    task_seconds: array[float] = field(default_factory=lambda: array("d"))
    groups: dict[str, SweepGroup] = field(default_factory=dict)

    def take(self, row: dict[str, Any]) -> None:
        """Take a row."""
        self.statuses[row["status"]] += 1
        for name in TIMES:
            getattr(self, name).append(row[name])
        key = json.dumps([row["tree"], row["scene"], row["set"]])
        if key not in self.groups:
            self.groups[key] = SweepGroup(row["tree"], row["scene"], row["set"])
        self.groups[key].take(row)

    def to_json(self) -> dict[str, Any]:
        """Return the content of summary.json."""
        return {
            "items": self.items,
            "statuses": dict(sorted(self.statuses.items())),
            "cpu_seconds": _spread(self.cpu_seconds),
            "wall_seconds_an_item": _spread(self.wall_seconds),
            "task_seconds": _spread(self.task_seconds),
            "groups": [group.to_json() for group in self.groups.values()],
        }


def write_summary(folder: Path, items: int, rows: Iterable[dict[str, Any]]) -> Summary:
    """Return the summary of the rows of a sweep of so many items, and write it into a folder."""
    summary = Summary(items)
    for row in rows:
        summary.take(row)
    text = json.dumps(summary.to_json(), indent=2, allow_nan=False, ensure_ascii=False)
    (folder / SUMMARY).write_text(text + "\n", encoding="utf-8")
    return summary


def _known(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    known: np.ndarray[Any, Any] = values[np.isfinite(values)]
    return known


def _mean(values: np.ndarray[Any, Any]) -> float | None:
    known = _known(values)
    return float(known.mean()) if known.size else None


def _rms(values: np.ndarray[Any, Any]) -> float | None:
    known = _known(values)
    return float(np.sqrt(np.mean(known**2))) if known.size else None


def _spread(values: array[float]) -> dict[str, float] | None:
    """Return sum, median, 95th percentile and largest of some times, s; None of none."""
    if not values:
        return None
    found = np.asarray(values, np.float64)
    named = {"sum": found.sum(), "median": np.median(found), "p95": np.percentile(found, 95), "largest": found.max()}
    return {name: float(value) for name, value in named.items()}
