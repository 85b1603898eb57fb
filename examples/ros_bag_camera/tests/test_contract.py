"""The driver keeps to what every depth camera does, on a small bag."""

import tempfile
from pathlib import Path

import numpy as np
from bags import write_bag

from stretch_bt.testing import device_contract

CELL = """\
format: stretch-cell/1
devices:
  camera: {type: DepthCamera, use: ros_bag, bag: press, plane_distance: 200 mm}
"""


def folder() -> Path:
    """Write a bag of three seconds and the cell file that plays it."""
    path = Path(tempfile.mkdtemp())
    noise = np.random.default_rng(0)
    write_bag(path / "press", (noise.integers(190, 210, (48, 64)).astype(np.uint16) for _ in range(90)))
    (path / "cell.yaml").write_text(CELL)
    return path / "cell.yaml"


TestBagCamera = device_contract(folder(), "camera", tolerance=0.001, latency=0.15)
