"""What is loaded before a robot moves is all that its task needs."""

import json
import subprocess
import sys

import pytest

#: runs a tree on the twin, and prints modules imported after the first tick, but the twin's own: with a robot it is in another process
PROGRAM = """
import json, sys
from stretch_bt import run
from stretch_bt.runtime.load_ahead import load_ahead
from stretch_bt.runtime.onlooker import Onlooker

load_ahead(json.loads(sys.argv[4]))
known, late = set(), set()

class Imports(Onlooker):
    def begin_tick(self, tick, time):
        late.update(set(sys.modules) - known if tick > 1 else ())
        known.update(sys.modules)

imports = Imports()
result = run(sys.argv[1], out=sys.argv[2], **json.loads(sys.argv[3]), watch=lambda runner: runner.watchers.append(imports))
print(json.dumps([result.status, sorted(name for name in late if not name.startswith("stretch_bt.simulation"))]))
"""


@pytest.mark.parametrize(
    ("tree", "params"),
    [
        (
            "palpate_stiffness",
            {"touches": 2, "touch_frames": 2, "sensing_frames": 2, "min_hold": 0.0, "settle": 0.0, "model": "paper"},
        ),
        *(pytest.param(tree, {}, marks=pytest.mark.slow) for tree in ("form_cookie_fast", "reconstruct")),
    ],
)
def test_a_task_loads_nothing_while_it_runs(at_hertz, hand_at, tmp_path, tree, params):
    options = {"params": params}
    if params:
        options |= {"scene": str(at_hertz("water_balloon", tmp_path)), "cell": str(hand_at(75))}
    asked = [sys.executable, "-c", PROGRAM, tree, tmp_path / "record", json.dumps(options), json.dumps(["DepthCamera"])]
    done = subprocess.run(asked, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert json.loads(done.stdout) == ["SUCCESS", []]


TREE = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper}
scene: water_balloon
trees: {main: {sequence: [{set_stretch: {stretch: 3 mm}}, {retract: {clearance: 20 mm}}]}}
"""


def test_a_task_without_a_camera_loads_nothing_of_what_one_sees_and_nothing_while_it_runs(tmp_path):
    (tmp_path / "tree.yaml").write_text(TREE)
    program = PROGRAM + "print(json.dumps('stretch_bt.perception.arrays_kernel' in sys.modules))\n"
    asked = [sys.executable, "-c", program, tmp_path / "tree.yaml", tmp_path / "record", "{}", '["Arm", "Gripper"]']
    done = subprocess.run(asked, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert [json.loads(line) for line in done.stdout.splitlines()] == [["SUCCESS", []], False]


def test_the_twin_itself_imports_nothing_in_a_tick(tmp_path):
    """No signal is heard while a tick imports."""
    (tmp_path / "tree.yaml").write_text(TREE)
    program = PROGRAM.replace("load_ahead(json.loads(sys.argv[4]))\n", "").replace(
        'if not name.startswith("stretch_bt.simulation")', ""
    )
    asked = [sys.executable, "-c", program, tmp_path / "tree.yaml", tmp_path / "record", "{}"]
    done = subprocess.run(asked, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert json.loads(done.stdout) == ["SUCCESS", []]
