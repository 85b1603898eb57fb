"""Whether the top of an object gives way under a press."""

from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics, Pose
from stretch_bt.perception.clouds.top_watch import APART, LATEST, TopWatch

CAMERA, DISTANCE = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333), 0.2
BY = 1e-3  # m


def look(top: float, hand: float, at: tuple[float, float] = (0.02, -0.01)) -> DepthFrame:
    """Return what a hand at a height over a place sees of a flat top at a height, m, world, all over its membrane."""
    raw = np.full((CAMERA.height, CAMERA.width), round((DISTANCE - (top - hand)) / 1e-5), np.uint16)
    return DepthFrame(raw, 1e-5, CAMERA, 0.0, 0, DISTANCE, hand_height=hand, stretch=0.0, pose=Pose((*at, hand)))


def answers(tops: list[float], place: tuple[float, float, float] = (0.02, -0.01, 0.06)) -> list[bool]:
    """Return what was said after each look at a top, m, as the hand sinks."""
    watch = TopWatch(place)
    return [watch.fell(look(top, 0.055 - k * APART), k * APART, BY) for k, top in enumerate(tops)]


@pytest.mark.parametrize(
    ("tops", "fell"),
    [
        ([0.06] * 6, [False] * 6),
        ([0.06 - 0.8 * BY] * 6, [False] * 6),
        ([0.06 - 1.5 * BY] * 4, [False, False, True, True]),  # not before there are enough looks
        ([0.06, 0.06, 0.06, 0.06 - 2 * BY, 0.06 - 2 * BY], [False] * 4 + [True]),  # by their mean, no single one
    ],
)
def test_a_top_fell_where_the_latest_looks_say_so_together(tops: list[float], fell: list[bool]) -> None:
    assert LATEST == 3
    assert answers(tops) == fell


def test_a_top_that_is_out_of_sight_has_not_fallen() -> None:
    assert not any(answers([0.05] * 5, place=(0.20, 0.0, 0.06)))


def test_looks_are_a_way_apart() -> None:
    watch = TopWatch((0.02, -0.01, 0.06))
    assert watch.is_due(0.0), "the first is due at once"
    watch.fell(look(0.06, 0.055), 0.002, BY)
    assert [watch.is_due(0.002 + part * APART) for part in (0.0, 0.9, 1.01)] == [False, False, True]


def test_a_frame_must_say_where_the_hand_is() -> None:
    with pytest.raises(InvalidInput, match="where the hand is"):
        TopWatch((0.0, 0.0, 0.06)).fell(replace(look(0.06, 0.055), pose=None), 0.0, BY)
