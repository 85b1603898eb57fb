"""The driver keeps to what every gripper does, on pymodbus's simulator server."""

import tempfile
from pathlib import Path

from stretch_bt_modbus_gripper.simulator import Simulator

from stretch_bt.testing import device_contract

CELL = """\
format: stretch-cell/1
devices:
  gripper: {{type: Gripper, use: two_jaw, host: 127.0.0.1, port: {}}}
"""


def cell(simulator: Simulator) -> Path:
    """Write the cell file, whose port is known only once the simulator listens."""
    path = Path(tempfile.mkdtemp()) / "cell.yaml"
    path.write_text(CELL.format(simulator.port))
    return path


TestTwoJaw = device_contract(
    cell,
    "gripper",
    kind="Gripper",
    start=Simulator,
    moves=(0.060, 0.080),
    tolerance=0.0002,
    latency=0.2,
    cut=lambda simulator: simulator.stop(),
)
