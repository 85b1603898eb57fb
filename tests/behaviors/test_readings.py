"""What the readings of a press say of a frame's noise."""

import math
from functools import partial
from typing import Any

import pytest

from stretch_bt.behaviors._readings import Reading, noise_at
from stretch_bt.behaviors.add_reading import AddReading
from stretch_bt.behaviors.records import ObservedTop, Touch
from stretch_bt.tree.ports import Status

LEFT, WHITE = 1e-4, 3e-4  # m


@pytest.mark.parametrize("left", [0.0, LEFT])
@pytest.mark.parametrize("frames", [1, 4, 64])
def test_what_more_frames_leave_is_no_noise_of_a_frame(left: float, frames: int) -> None:
    """With 64 frames what the camera's static error leaves made the noise of one 2.8 times too large, and many looks seem worth it."""
    sd = math.hypot(left, WHITE / math.sqrt(frames))
    press = Reading(0.0, 0.005, 0.06, sd, frames=frames, fixed=left)
    noise, fixed = noise_at([press], press)
    assert noise == pytest.approx(WHITE)
    assert fixed == pytest.approx(math.hypot(left, 3e-5))


@pytest.mark.parametrize("fixed", [0.0, LEFT])
def test_a_reading_keeps_what_no_averaging_takes_away_of_its_height(fixed: float) -> None:
    """A height by the whole membrane has none of the static error."""
    node = AddReading("main/add_reading")
    seen = ObservedTop(0.058, math.hypot(fixed, WHITE), fixed, by_membrane=fixed == 0.0)
    inputs: dict[str, Any] = {
        "touch": Touch(0.06, 2e-5),
        "observed_top": seen,
        "stretch": 0.01,
        "depth": 0.005,
        "frames": 1,
    }
    for name, port in AddReading.ports.items():
        if not port.written:
            node.wiring[name] = partial(inputs.get, name, port.default)
    node.sinks["top_readings"].value = None
    for _ in node.tick():
        pass
    assert node.status is Status.SUCCESS, node.reason
    [reading] = node.sinks["top_readings"].value.readings
    assert (reading.depth, reading.hand) == (pytest.approx(0.003), pytest.approx(0.055)), "less what the top gave way"
    assert (reading.stretch, reading.by_membrane) == (0.01, fixed == 0.0)
    assert noise_at([reading], reading) == pytest.approx((WHITE, math.hypot(fixed, 3e-5)))
