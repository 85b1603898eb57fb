"""An operator mounts an indenter."""

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import Status


def test_mount_asks_waits_and_forgets_the_contact(bench):
    operator = ScriptedDevice("Operator", motion=[MotionState.MOVING, MotionState.DONE])
    made = bench(operator=operator)
    node = made.run("mount", geometry="cone", angle=0.785)
    assert node.status is Status.SUCCESS
    (command,) = operator.commands
    assert (command.name, command.arguments) == ("mount", {"geometry": "cone", "size": 0.785})
    assert made.context.hand.contact_height is None


@pytest.mark.parametrize(
    ("inputs", "said"), [({"geometry": "ball"}, "no indenter 'ball'"), ({"geometry": "sphere"}, "no sphere of 0 mm")]
)
def test_mount_knows_before_the_run_what_cannot_be(bench, inputs, said):
    with pytest.raises(InvalidInput, match=said):
        bench().node("mount", **inputs).prepare()
