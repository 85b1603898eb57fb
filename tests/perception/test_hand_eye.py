import math

import numpy as np
import pytest

from stretch_bt.perception import DepthFrame, Intrinsics
from stretch_bt.perception.hand_eye import view_of_hand

MM = 1e-3
LENGTH, WIDTH, DISTANCE = 110 * MM, 90 * MM, 0.2
CAMERA = Intrinsics(280.0, 280.0, 119.5, 119.5, 240, 240)


def seen_from(place, yaw):
    """A flat membrane over a table, from a camera that looks straight down on it and is turned about its axis."""
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    ray = np.stack([u - CAMERA.cx, v - CAMERA.cy], axis=-1) / CAMERA.fx * DISTANCE
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    x, y = np.moveaxis(ray @ turn.T + place, -1, 0)
    depth = np.where((np.abs(x) < WIDTH / 2) & (np.abs(y) < LENGTH / 2), DISTANCE, DISTANCE + 80 * MM)
    return DepthFrame.from_array(depth, CAMERA, unit=1e-5, plane_distance=DISTANCE)


@pytest.mark.parametrize("degrees", [-15.0, -6.0, 0.0, 10.0])
def test_a_camera_that_is_turned_sees_the_membrane_as_long_as_it_is_and_where_it_is(degrees):
    place, yaw = np.array([3 * MM, -4 * MM]), math.radians(degrees)
    view = view_of_hand(seen_from(place, yaw), DISTANCE)
    truths = {"length": LENGTH, "yaw": yaw, "x": place[0], "y": place[1], "aim_x": place[0], "aim_y": place[1]}
    for name, truth in truths.items():
        found = getattr(view, name)
        assert abs(found.value - truth) < 2.5 * found.sd, name
