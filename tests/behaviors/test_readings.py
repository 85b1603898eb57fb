"""What the readings of a press say of a frame's noise."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.behaviors._membrane import keep_how
from stretch_bt.behaviors._readings import Reading, noise_at, readings_of
from stretch_bt.perception.pattern import Pattern
from stretch_bt.run.context import RunContext

LEFT, WHITE = 1e-4, 3e-4  # m
EMPTY = np.zeros((2, 2), np.float32)
PATTERN = Pattern(EMPTY, EMPTY, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("left", [0.0, LEFT])
@pytest.mark.parametrize("frames", [1, 4, 64])
def test_what_more_frames_leave_is_no_noise_of_a_frame(left: float, frames: int) -> None:
    """With 64 frames what the camera's static error leaves made the noise of one 2.8 times too large, and many looks seem worth it."""
    context = RunContext()
    context.memory[Pattern] = replace(PATTERN, left=left)
    press = Reading(0.0, 0.005, 0.06, math.hypot(left, WHITE / math.sqrt(frames)), frames=frames)
    readings_of(context).append(press)
    noise, fixed = noise_at(context, press)
    assert noise == pytest.approx(WHITE)
    assert fixed == pytest.approx(math.hypot(left, 3e-5))


def test_a_height_by_the_whole_membrane_has_none_of_the_static_error() -> None:
    context = RunContext()
    context.memory[Pattern] = replace(PATTERN, left=LEFT)
    keep_how(context, by_membrane=True)
    press = Reading(0.0, 0.005, 0.06, WHITE)
    readings_of(context).append(press)
    assert noise_at(context, press) == pytest.approx((WHITE, 3e-5))
