"""Tasks with this gripper beside a simulated arm and camera: the membrane is stretched as the gripper says."""

import pytest
from stretch_bt_modbus_gripper.simulator import Simulator

import stretch_bt

CELL = """\
format: stretch-cell/1
devices:
  gripper: {{type: Gripper, use: two_jaw, host: 127.0.0.1, port: {}}}
  arm: {{type: Arm, use: simulated, height: 120 mm}}
  camera: {{type: DepthCamera, use: simulated}}
"""


@pytest.fixture
def cell(tmp_path):
    simulator = Simulator()
    path = tmp_path / "cell.yaml"
    path.write_text(CELL.format(simulator.port))
    yield path
    simulator.stop()


def test_frames_say_how_far_the_gripper_stretched(cell):
    with stretch_bt.open_cell(cell, scene="calibration_sphere") as opened:
        opened.do("set_stretch", stretch="30 mm", speed="100 mm/s", timeout="10 s")
        frame = opened.do("capture").frame
        assert frame.stretch == pytest.approx(0.030, abs=5e-4)
        assert opened.truth()["stretch"] == pytest.approx(0.030, abs=5e-4)
