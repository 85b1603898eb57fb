"""The numbers of a palpation that ended in a stiffness."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stretch_bt.accuracy.palpation.palpated import PalpationTruth
from stretch_bt.runtime.result import RunResult
from stretch_bt.simulation.objects.balloon import BalloonObject
from stretch_bt.simulation.scene import load_scene

__all__ = ["DROP", "Figures", "figures"]

DROP = 1.5e-3  # m, at which the trees estimate the second stiffness


class Figures(NamedTuple):
    """Errors relative to the truth and in stated standard deviations, drops and heights in mm, times in s.

    The stiffness at the last press is compared with the scene's own at that moment, the stiffness at DROP with the object's own.
    """

    error: float
    error_in_sd: float
    drop_error: float
    drop_error_in_sd: float
    deflection_error: float
    deflection_sd: float
    height_scatter: float  # of looks about the run's mean error; NaN where there was one
    presses: float
    robot_seconds: float
    past_touch: float  # seconds since the hand stood at the object's top
    falls: float  # presses at whose end the scene's own force was lower than at the last


def figures(result: RunResult, seen: PalpationTruth, balloon: str) -> Figures:
    """Return the numbers of one run, whose status is SUCCESS."""
    out, true = result.outputs, result.truth
    spec = load_scene(f"{balloon}_balloon").object
    assert isinstance(spec, BalloonObject)
    found, dropped, seconds = out["stiffness"], out["stiffness_at_drop"], out["robot_time"]["value"]
    error = found["value"] / true["stiffness"]["value"] - 1
    off = dropped["value"] / (spec.secant(DROP) / 1e3) - 1
    return Figures(
        error,
        error / (found["sd"] / found["value"]),
        off,
        off / (dropped["sd"] / dropped["value"]),
        out["deflection"]["value"] - true["deflection"]["value"],
        out["deflection"]["sd"],
        float(np.std(seen.errors)) * 1e3 if len(seen.errors) > 1 else float("nan"),
        out["presses"]["value"],
        seconds,
        seconds - (seen.touched or 0.0),
        seen.falls(),
    )
