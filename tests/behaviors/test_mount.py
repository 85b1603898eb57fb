"""An operator mounts an indenter."""

import pytest

from stretch_bt import run
from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import MISSING, Status

TREE = """\
format: stretch-tree/1
devices: {arm: Arm, operator: Operator}
scene: calibration_sphere
trees: {main: {sequence: [mount: {geometry: sphere, diameter: 20 mm}, press: {depth: 5 mm}]}}
"""


def test_mount_asks_waits_and_forgets_the_contact(bench):
    operator = ScriptedDevice("Operator", motion=[MotionState.MOVING, MotionState.DONE])
    made = bench(operator=operator)
    made.context.hand.contact_height = 0.060
    node = made.run("mount", geometry="cone", angle=0.785)
    assert node.status is Status.SUCCESS
    (command,) = operator.commands
    assert (command.name, command.arguments) == ("mount", {"geometry": "cone", "size": 0.785})
    assert made.keys["touch"].value is MISSING
    assert made.context.hand.contact_height is None


@pytest.mark.parametrize(
    ("inputs", "said"), [({"geometry": "ball"}, "no indenter 'ball'"), ({"geometry": "sphere"}, "no sphere of 0 mm")]
)
def test_mount_knows_before_the_run_what_cannot_be(bench, inputs, said):
    with pytest.raises(InvalidInput, match=said):
        bench().node("mount", **inputs).prepare()


def test_after_a_mount_the_hand_does_not_press_until_it_touched_again(tmp_path):
    """A depth would count from the height of what stood there before."""
    (tmp_path / "tree.yaml").write_text(TREE)
    result = run(tmp_path / "tree.yaml", out=tmp_path / "record")
    assert (result.status, result.reason) == (
        "FAILURE",
        "main/press: $main/touch is none: main/mount had no value for it",
    )
