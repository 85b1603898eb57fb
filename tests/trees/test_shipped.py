"""Every shipped tree: checked, and ticked to SUCCESS and to FAILURE under mocks, without a scene or a device."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from stretch_bt.run.check import check
from stretch_bt.tree.program import shipped_trees

MOCKS = Path(__file__).parent / "mocks"
TREES = shipped_trees()

#: run in a process of its own, so that what it imports is its own doing
SCRIPT = """
import json, sys
from stretch_bt import run
result = run(sys.argv[1], mocks=sys.argv[2], out=sys.argv[3])
heavy = ("stretch_bt.simulation", "stretch_bt.hardware.cell", "stretch_bt.hardware.driver", "stretch_bt.hardware.simulated",
         "stretch_bt.hardware.replay", "stretch_bt.hardware.monitored", "cv2", "pymodbus", "rtde_control", "rtde_receive")
print(json.dumps({**result.to_json(), "imported": [m for m in sys.modules if m.startswith(heavy)]}))
"""


def test_both_shipped_tasks_are_here():
    assert {"palpate_stiffness", "watch_contact"} <= set(TREES)


@pytest.mark.parametrize("tree", TREES)
def test_checks_clean(tree):
    from stretch_bt.tree.headings import shipped

    assert check(shipped(f"{tree}.yaml")) == []


@pytest.mark.parametrize("ending", ["success", "failure"])
@pytest.mark.parametrize("tree", TREES)
def test_ticks_to_its_end_under_mocks(tree, ending, tmp_path):
    mocks = MOCKS / f"{tree}_{ending}.yaml"
    assert check(mocks) == []
    command = [sys.executable, "-W", "error", "-c", SCRIPT, tree, str(mocks), str(tmp_path / "record")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    result = json.loads(done.stdout)
    assert (result["status"], result["unmet"]) == (ending.upper(), []), result["reason"]
    assert result["imported"] == []
    assert result["truth"] == {}


def test_the_mocked_palpation_reports_force_over_drop(tmp_path, run):
    result = run("palpate_stiffness", mocks=MOCKS / "palpate_stiffness_success.yaml")
    out = result.outputs
    assert abs(out["deflection"]["value"] - 1.7) < 2 * out["deflection"]["sd"] < 0.3
    assert out["stiffness"]["value"] == pytest.approx(out["force"]["value"] / out["deflection"]["value"])
    assert out["stiffness"]["unit"] == out["stiffness_at_drop"]["unit"] == "N/mm"
    assert 0.5 < out["stiffness_at_drop"]["value"] / out["stiffness"]["value"] < 1, "at less of a drop it is softer"
    assert out["stiffness"]["sd"] > 0
    assert out["hold"]["value"] >= 2.0
    assert out["presses"] == {"value": 3, "unit": "", "sd": None}
