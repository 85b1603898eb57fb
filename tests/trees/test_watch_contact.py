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

recorded = pytest.mark.skipif(not DATA.exists(), reason=f"needs the recorded press at {DATA.parent.name}/{DATA.name}")


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


@recorded
def test_every_frame_is_watched_once_and_height_follows_the_force(watched, force):
    result, events = watched
    assert result.status == "SUCCESS", result.reason
    heights = [e["value"] for e in events if e["type"] == "write" and e["key"] == "main/height"]
    assert result.outputs["frames"]["value"] == len(heights) == 75
    assert np.corrcoef(heights, force[1])[0, 1] >= 0.98


@recorded
def test_contact_begins_and_ends_with_the_wrench(watched, force):
    outputs = watched[0].outputs
    times, magnitude = force
    pressed = times[magnitude > 1.5]
    assert outputs["touches"]["value"] == 1
    assert outputs["contact_on"]["value"] == pytest.approx(pressed[0], abs=0.2)
    assert outputs["contact_off"]["value"] == pytest.approx(times[times > pressed[-1]][0], abs=0.2)


@pytest.mark.parametrize(
    ("seen", "found"),
    [
        ([False, False], set()),
        ([False, True], {"contact_on", "highest"}),
        ([False, True, False], {"contact_on", "contact_off", "highest"}),
    ],
)
def test_what_did_not_happen_is_absent(seen, found):
    from stretch_bt import run

    mocks = [
        {"match": "main/capture", "outputs": {"frame": [{"time": "0 s"}]}},
        {"match": "main/watch/detect_contact", "outputs": {"in_contact": seen}},
        {"match": "main/watch/track_height", "outputs": {"height": "2 mm"}},
        {
            "match": "main/watch/capture",
            "status": [*(["success"] * (len(seen) - 1)), "failure"],
            "outputs": {"frame": [{"time": f"{i} s"} for i in range(1, len(seen) + 1)]},
        },
    ]
    result = run("watch_contact", mocks={"mocks": mocks}, record="none")
    assert result.status == "SUCCESS", result.reason
    assert set(result.outputs) == {"frames", "touches"} | found
    assert {name: result.outputs[name]["value"] for name in found - {"highest"}} == {
        name: {"contact_on": 1.0, "contact_off": 2.0}[name] for name in found - {"highest"}
    }
