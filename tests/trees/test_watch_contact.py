"""watch_contact on a real press of a real membrane; the wrench is the truth, and is not looked at."""

import json
from pathlib import Path

import numpy as np
import pytest

DATA = Path(__file__).parents[2].parent / "shared" / "data" / "membrane_press" / "punyo_press_z.npz"
CELL = f"""\
format: stretch-cell/1
devices:
  camera:
    {{type: DepthCamera, use: replay, file: {DATA}, depth: z_0p1mm, time: t, unit: 0.1 mm, intrinsics: K, roi: roi}}
"""

pytestmark = pytest.mark.skipif(not DATA.exists(), reason=f"needs the recorded press at {DATA.parent.name}/{DATA.name}")


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    from stretch_bt import run

    folder = tmp_path_factory.mktemp("watch")
    (folder / "cell.yaml").write_text(CELL)
    result = run("watch_contact", cell=folder / "cell.yaml", out=folder / "record")
    events = [json.loads(line) for line in (folder / "record" / "events.jsonl").read_text().splitlines()]
    return result, events


@pytest.fixture(scope="module")
def force():
    with np.load(DATA) as data:
        return data["t"] - data["t"][0], np.linalg.norm(data["wrench"][:, :3], axis=1)


def test_every_frame_is_watched_once_and_height_follows_the_force(watched, force):
    result, events = watched
    assert result.status == "SUCCESS", result.reason
    heights = [e["value"] for e in events if e["type"] == "write" and e["key"] == "main/height"]
    assert result.outputs["frames"]["value"] == len(heights) == 75
    assert np.corrcoef(heights, force[1])[0, 1] >= 0.98


def test_contact_begins_and_ends_with_the_wrench(watched, force):
    outputs = watched[0].outputs
    times, magnitude = force
    pressed = times[magnitude > 1.5]
    assert outputs["touches"]["value"] == 1
    assert outputs["contact_on"]["value"] == pytest.approx(pressed[0], abs=0.2)
    assert outputs["contact_off"]["value"] == pytest.approx(times[times > pressed[-1]][0], abs=0.2)
