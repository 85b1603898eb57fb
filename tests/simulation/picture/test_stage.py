import numpy as np
import pytest

from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.simulation.camera.sensor import window
from stretch_bt.simulation.picture import Stage
from stretch_bt.simulation.picture.above import height_map
from stretch_bt.simulation.picture.stage import act
from stretch_bt.simulation.scene import load_scene


class Clock:
    """A clock that stands where it is put."""

    time = 0.0

    def __call__(self):
        return self.time


@pytest.mark.parametrize("name", ["calibration_sphere", "calibration_cylinder"])
def test_the_frame_is_that_of_the_simulated_camera(name):
    scene = load_scene(name).with_(effects="none", fidelity="hertz")
    cell, clock = load_cell("simulated"), Clock()
    lens = window(cell.hand.width, cell.hand.gauge + cell.limits.stretch.max, cell.hand.plane_distance)
    moment = act(scene, Stage(lens=lens))
    devices = open_cell(cell, now=clock, scene=scene).devices
    devices["gripper"].move(cell.hand.rest_opening + scene.conditions.stretch, speed=0.1, owner="test")
    clock.time = 1.0
    devices["arm"].move(Pose((0, 0, scene.object.top - scene.conditions.depth)), speed=0.2, owner="test")
    clock.time = 20.0
    still = devices["camera"].frame(1.0).value
    assert np.array_equal(still.raw, moment.frame.raw)
    assert still.hand_height == pytest.approx(moment.frame.hand_height)


def test_the_map_of_heights_is_that_of_the_membrane():
    scene = load_scene("calibration_sphere").with_(effects="none", fidelity="hertz")
    moment = act(scene, Stage())
    height, x, y = height_map(moment)
    across, along = np.meshgrid(x, y)
    surface = moment.skin.surface
    there = np.isfinite(height)
    away = np.hypot(across, along)
    assert height[there] == pytest.approx(surface.height(away)[there], abs=2e-5)
    assert there.sum() == pytest.approx(0.090 * (0.100 + scene.conditions.stretch) / 0.4e-3**2, rel=0.02)
