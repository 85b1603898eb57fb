"""`watch_contact` runs on a bag: frames of a membrane that something touches twice."""

from pathlib import Path

import numpy as np
from bags import write_bag

from stretch_bt import run

CELL = Path(__file__).parents[1] / "cell.yaml"
SHAPE, FOCAL, RATE = (240, 320), 300.0, 15.0
PLANE, RADIUS, DEPTH = 0.200, 0.030, 0.008


def pictures() -> list[np.ndarray]:
    """Return pictures of a flat membrane that a ball lifts by 8 mm between 1 s and 2 s, and between 3 s and 4 s; counts of 1 mm."""
    v, u = np.indices(SHAPE)
    across, along = ((n - size / 2) * PLANE / FOCAL for n, size in ((u, SHAPE[1]), (v, SHAPE[0])))
    far = np.hypot(across, along)
    random = np.random.default_rng(0)
    found = []
    for number in range(75):
        second = number / RATE
        pressed = 1 <= second < 2 or 3 <= second < 4
        rise = DEPTH * np.exp(-((far / RADIUS) ** 2)) if pressed else np.zeros(SHAPE)
        noise = random.normal(0, 0.0005, SHAPE)
        found.append(np.rint(1e3 * (PLANE - rise + noise)).astype(np.uint16))
    return found


def test_contact_is_seen_twice(tmp_path: Path) -> None:
    """The task ends with the recording, and counts both touches."""
    write_bag(tmp_path / "press", pictures(), focal=FOCAL, rate=RATE)
    (tmp_path / "cell.yaml").write_text(CELL.read_text())
    result = run("watch_contact", cell=tmp_path / "cell.yaml", params={"duration": "20 s"}, out=tmp_path / "record")
    assert result.status == "SUCCESS", result.reason
    assert result.outputs["touches"]["value"] == 2
