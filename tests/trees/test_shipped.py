"""Every shipped tree: checked, and ticked to SUCCESS and to FAILURE under mocks, without a scene or a device."""

import json
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from stretch_bt.runtime.check import check
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.tree.program import load_program, shipped_trees

MOCKS = Path(__file__).parent / "mocks"
TREES = shipped_trees()
#: trees that move an arm
MOVING = [tree for tree in TREES if "arm" in load_program(tree).document.devices]
#: the ones that are interrupted in the default run
QUICK = ("reconstruct",)
#: N, at which a run is interrupted
PRESSED = 0.3
ENDINGS = ("success", "failure")

#: run in a process of its own, so that all imports there come from the runs
SCRIPT = """
import json, sys
from stretch_bt import run
each, given = int(sys.argv[1]), sys.argv[2:]
trees, mocks = given[: len(given) // (each + 1)], given[len(given) // (each + 1) :]
results = [
    [run(tree, mocks=m, out=f"{m}.record").to_json() for m in mocks[each * n : each * (n + 1)]]
    for n, tree in enumerate(trees)
]
heavy = ("stretch_bt.simulation", "stretch_bt.hardware.cell", "stretch_bt.hardware.driver", "stretch_bt.hardware.simulated",
         "stretch_bt.hardware.replay", "stretch_bt.hardware.monitored", "cv2", "pymodbus", "rtde_control", "rtde_receive")
print(json.dumps([results, [m for m in sys.modules if m.startswith(heavy)]]))
"""


def test_both_shipped_tasks_are_here():
    assert {"palpate_stiffness", "watch_contact"} <= set(TREES)


@pytest.mark.parametrize("tree", TREES)
def test_checks_clean(tree):
    from stretch_bt.tree.shared import shipped

    assert check(shipped(f"{tree}.yaml")) == []


@pytest.fixture(scope="module")
def ticked(tmp_path_factory):
    """Return by tree its results under the mocks of each ending, and what all of them together imported."""
    folder = tmp_path_factory.mktemp("mocks")
    mocks = [shutil.copy(MOCKS / f"{tree}_{ending}.yaml", folder) for tree in TREES for ending in ENDINGS]
    command = [sys.executable, "-W", "error", "-c", SCRIPT, str(len(ENDINGS)), *TREES, *mocks]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    results, imported = json.loads(done.stdout)
    return dict(zip(TREES, results, strict=True)), imported


@pytest.mark.parametrize("tree", TREES)
def test_ticks_to_its_ends_under_mocks(tree, ticked):
    for ending in ENDINGS:
        assert check(MOCKS / f"{tree}_{ending}.yaml") == []
    results, imported = ticked[0][tree], ticked[1]
    for ending, result in zip(ENDINGS, results, strict=True):
        assert (result["status"], result["unmet"]) == (ending.upper(), []), result["reason"]
        assert result["truth"] == {}
    assert imported == []


def test_the_mocked_palpation_reports_force_over_drop(tmp_path, run):
    result = run("palpate_stiffness", mocks=MOCKS / "palpate_stiffness_success.yaml")
    out = result.outputs
    assert abs(out["deflection"]["value"] - 3.1) < 2 * out["deflection"]["sd"] < 0.3
    assert out["stiffness"]["value"] == pytest.approx(out["force"]["value"] / out["deflection"]["value"])
    assert out["stiffness"]["unit"] == out["stiffness_at_drop"]["unit"] == "N/mm"
    assert 0.5 < out["stiffness_at_drop"]["value"] / out["stiffness"]["value"] < 1, "at less of a drop it is softer"
    assert out["stiffness"]["sd"] > 0
    assert out["hold"]["value"] >= 2.0
    assert out["presses"] == {"value": 2, "unit": "", "sd": None}


class Interrupts(Onlooker):
    """Interrupts a run once, as the hand presses on the object."""

    def __init__(self, runner):
        self.runner, self.made = runner, False

    def begin_tick(self, tick, time):
        if not self.made and self.runner.cell.truth()["force"] > PRESSED:
            self.made = True
            signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize("tree", [pytest.param(t, marks=[pytest.mark.slow] * (t not in QUICK)) for t in MOVING])
def test_the_hand_is_raised_from_the_object_when_a_run_is_interrupted(run, tree):
    onlookers = []

    def watch(runner):
        onlookers.append(Interrupts(runner))
        runner.watchers.append(onlookers[0])

    assert run(tree, watch=watch).status == "INTERRUPTED"
    assert onlookers[0].made
    assert onlookers[0].runner.cell.truth()["force"] == 0.0


@pytest.mark.parametrize("tree", TREES)
def test_every_param_may_be_at_its_bounds(tree):
    """More frames than an average of a called tree takes were refused, although the param lets them be."""
    for name, param in load_program(tree).document.params.items():
        for bound in {param.min, param.max} - {None}:
            assert not load_program(tree, {name: int(bound) if param.type.name == "int" else bound}).errors, (
                name,
                bound,
            )
