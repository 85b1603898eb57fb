"""Files that hold no force model."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.domains.model.force_models import HERTZ, LIMITS, MEMBRANE
from stretch_bt.hardcases.expect import Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model import ForceModel

Change = Callable[[dict[str, Any]], Any]


HERTZ_FILES: dict[str, tuple[dict[str, Any], str]] = {
    "another format": ({"format": "stretch-calibration/9"}, "format"),
    "another kind": ({"kind": "oracle"}, "oracle"),
    "no state": ({"states": []}, "two different stretches"),
    "no logarithm": ({"log_scale": 0.0}, "log_scale"),
    "half a range": ({"range": {"radius": [0, 1]}}, "range: it has the ends of"),
    "a radius of metres": (
        {"range": {"radius": [0, 5], "stretch": [0, 0.08], "depth": [0, 0.01]}},
        "range.radius: .* from 0 to 1 m",
    ),
    "a stretch of metres": (
        {"range": {"radius": [0, 0.1], "stretch": [0, 5], "depth": [0, 0.01]}},
        "range.stretch: .* from 0 to 0.2 m",
    ),
    "a deviation below 0": ({"relative_sd": -1}, "relative_sd: .* not -1"),
    "a deviation that is text": ({"shallow_sd": "much"}, "shallow_sd: .* not 'much'"),
    "a scale that may be any": ({"log_scale_sd": 1e3}, "log_scale_sd: .* from 0 to 5, not 1000"),
    "one correlation": ({"correlation": [[1.0]]}, "correlation: it has 24 rows of 24"),
    "a correlation that is text": ({"correlation": "much"}, "correlation: it has 24 rows of 24"),
    "a parameter that is not itself": (
        {"correlation": [[0.5 * (i == j) for j in range(24)] for i in range(24)]},
        "correlation: each parameter is correlated by 1 with itself, not by 0.5",
    ),
}


def _set(**changes: Any) -> Change:
    """Return a change of a file's fields, by names with `__` between levels."""

    def change(kept: dict[str, Any]) -> None:
        for name, value in changes.items():
            *path, last = name.split("__")
            inner = kept
            for key in path:
                inner = inner[key]
            inner[last] = value

    return change


def _update(fields: dict[str, Any]) -> Change:
    return lambda kept: kept.update(fields)


def _spoil(kept: dict[str, Any]) -> None:
    rows = kept["covariance"]
    rows[0][1] = rows[1][0] = 2 * math.sqrt(rows[0][0] * rows[1][1])


def _turn(kept: dict[str, Any]) -> None:
    kept["covariance"][2][2] *= -1


def _tilt(kept: dict[str, Any]) -> None:
    rows = kept["covariance"]
    rows[0][1] = 0.5 * math.sqrt(rows[0][0] * rows[1][1])


MEMBRANE_FILES: dict[str, tuple[Change, str]] = {
    "softening 3": (_set(hand__softening=3), "hand.softening: it is a number from 0 to 0.5, not 3"),
    "a modulus below 0": (_set(hand__shear_modulus=-1), "hand.shear_modulus: .* not -1"),
    "a thickness below 0": (_set(hand__thickness=-1), "hand.thickness: .* not -1"),
    "friction that is text": (_set(hand__friction="much"), "hand.friction: .* not 'much'"),
    "parameters correlated by 2": (_spoil, "covariance: some sum of the parameters has a variance below 0"),
    "a variance below 0": (_turn, "covariance: a variance is not below 0"),
    "half a covariance": (_tilt, "covariance: it is not symmetric"),
    "one variance": (_set(covariance=[[1.0]]), "covariance: it has 6 rows of 6"),
    "a stretch of metres": (
        _set(range__stretch=[0, 5]),
        "range.stretch: its ends are numbers that rise, from 0 to 0.2 m",
    ),
    "a stretch past its table": (
        _set(range__stretch=[0, 0.15]),
        "range.stretch: it is a number from 0 to 0.12, not 0.15",
    ),
    "a depth past its table": (_set(range__depth=[0, 0.05]), "range.depth: .* 0.025"),
    "a radius below its table": (_set(range__radius=[0.001, 0.03]), "range.radius: .* from 0.004 to 0.06"),
    "ends that fall": (_set(range__radius=[0.03, 0.01]), "range.radius: its ends are numbers that rise"),
    "a range that is a number": (_set(range=5), "range: it has the ends of radius, stretch, depth"),
    "half of what was measured": (_set(measured={"radius": [0, 1]}), "measured: it has the ends"),
    "a radius of 0 measured": (_set(measured__radius=[0, 0.03]), "measured.radius: it is a number from .* not 0"),
    "a deviation below 0": (_set(relative_sd=-0.1), "relative_sd"),
    "conditioned to metres": (_set(conditioned=7), "conditioned: .* 0.2"),
}


def _loaded(
    model: Any, change: Change | None = None, *, text: str | None = None, name: str = "hand.json"
) -> ForceModel:
    """Return a model of a file that is written so."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "hand.json"
        model.save(path)
        kept = json.loads(path.read_text())
        if change is not None:
            change(kept)
        path.write_text(json.dumps(kept) if text is None else text)
        return ForceModel.load(Path(folder) / name)


def _without(field: str) -> Change:
    return lambda kept: kept.pop(field)


def _fit(name: str) -> bool:
    """Whether a file with or without the measured range is read as the model that was written."""
    model = replace(MEMBRANE, measured=LIMITS) if name == "measured" else MEMBRANE
    return _loaded(model, _without("measured") if name == "unmeasured" else None) == model


CASES: tuple[Hard, ...] = (
    *group(
        "a file may be broken or hold a field that no hand has, which the error must name",
        {
            name: (
                partial(_loaded, HERTZ, _update(change)),
                Refusal(InvalidInput, said),
            )
            for name, (change, said) in HERTZ_FILES.items()
        },
        {
            "broken": (partial(_loaded, HERTZ, text="{"), Refusal(InvalidInput, "hand.json")),
            "missing": (partial(_loaded, HERTZ, name="none.json"), Refusal(InvalidInput, "none.json")),
            "as it was": (partial(_loaded, HERTZ), Value(True, of=lambda model: model == HERTZ)),
        },
        prefix="file of a hertz model, ",
    ),
    *group(
        "a file may be broken or hold a field that no hand has, which the error must name",
        {
            name: (
                partial(_loaded, replace(MEMBRANE, measured=LIMITS), change),
                Refusal(InvalidInput, rf"hand\.json: {said}"),
            )
            for name, (change, said) in MEMBRANE_FILES.items()
        },
        {f"as it was, {name}": (partial(_fit, name), Value(True)) for name in ("measured", "unmeasured")},
        prefix="file of a membrane model, ",
    ),
)
