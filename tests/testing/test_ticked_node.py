"""One node on hand-made values: its inputs, its outputs, and the messages for wrong inputs."""

from typing import ClassVar

import numpy as np
import pytest

from stretch_bt import Behavior, In, InOut, Out, Status, Uses, port
from stretch_bt.behaviors.records import Touch
from stretch_bt.errors import DeviceLost, IllConditioned, InvalidInput
from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import Arm, MotionState
from stretch_bt.perception import Sphere
from stretch_bt.tree import registry
from stretch_bt.units import Estimate, Force, Length, Time


class OwnMean(Behavior):
    """Average forces over some ticks, as a node of a stranger may."""

    forces: In[list[Force]]
    wait: In[Time] = 0.0
    force_sd: In[Force] = 0.1
    force: In[Force] = 0.0
    scale: In[float] = port(1.0, min=0.1, max=10.0)
    sphere: In[Sphere | None] = None
    arm: Uses[Arm | None]
    seen: InOut[Touch | None]
    mean: Out[Force]
    radius: Out[Length | None]

    def update(self) -> Status:
        """Wait, then average."""
        if self.context.time < self.wait - 1e-9:
            return Status.RUNNING
        if not self.forces:
            raise IllConditioned("there is no force")
        if self.scale == 9.0:
            raise ValueError("nine")
        self.seen = Touch((self.seen.height if self.seen else 0.0) + 1.0, 0.0)
        self.mean = Estimate(self.scale * sum(self.forces) / len(self.forces), self.force_sd)
        if self.sphere:
            self.radius = self.sphere.radius
        return Status.SUCCESS


@pytest.fixture(autouse=True)
def own(monkeypatch):
    monkeypatch.setattr(registry, "_nodes", dict(registry.load_all()))
    registry.node(OwnMean)


#: forces and more inputs -> the mean and its deviation
GIVEN = {
    "numbers": ({"forces": [1.0, 3.0]}, 2.0, 0.1),
    "text": ({"forces": ["1 N", "3000 mN"], "scale": "50 %"}, 1.0, 0.1),
    "array": ({"forces": np.array([1.0, 3.0]), "scale": np.float32(2.0)}, 4.0, 0.1),
    "deviation": ({"forces": [1.0], "force": Estimate(1.0, 0.5)}, 1.0, 0.5),
    "both": ({"forces": [1.0], "force": Estimate(1.0, 0.5), "force_sd": "2 N"}, 1.0, 2.0),
}


@pytest.mark.parametrize("form", GIVEN)
def test_inputs_are_numbers_text_arrays_and_estimates(tick_node, form):
    inputs, mean, sd = GIVEN[form]
    result = tick_node("own_mean", **inputs)
    assert (result.status, result.reason) == ("SUCCESS", "")
    assert result.mean == Estimate(mean, sd)
    assert result.outputs["mean"].sd == sd
    assert result.radius is None


@pytest.mark.parametrize("name", ["own_mean", OwnMean, f"{__name__}.own_mean"], ids=["name", "class", "module"])
def test_a_node_is_named_in_three_ways(tick_node, name, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, __name__, object())
    assert tick_node(name, forces=[1.0]).mean == Estimate(1.0, 0.1)


BESIDE = '''\
"""A node of a module beside the test."""
from stretch_bt import Behavior, Out, Status, node


@node
class BesideTest(Behavior):
    """Say one."""

    one: Out[int]

    def update(self):
        self.one = 1
        return Status.SUCCESS
'''


def test_a_module_beside_the_test_is_imported(tmp_path, monkeypatch):
    from stretch_bt.testing.node_named import node_info
    from stretch_bt.testing.ticked_node import tick_node

    (tmp_path / "beside_nodes.py").write_text(BESIDE, encoding="utf-8")
    assert tick_node(node_info("beside_nodes.beside_test", tmp_path), {}).one == 1
    with pytest.raises(
        InvalidInput, match="module 'beside_nodes' has no node 'beside_tset'; did you mean 'beside_test'"
    ):
        node_info("beside_nodes.beside_tset", tmp_path)
    with pytest.raises(InvalidInput, match="no Python module 'beside_node' is installed"):
        node_info("beside_node.beside_test", tmp_path)


def test_it_ticks_until_the_node_ends(tick_node):
    result = tick_node("own_mean", forces=[1.0], wait="1 s")
    assert (result.ticks, result.seconds) == (21, pytest.approx(1.0))
    endless = tick_node("own_mean", forces=[1.0], wait="1 h")
    assert (endless.status, endless.reason) == ("FAILURE", "no end after 12000 ticks")


def test_records_go_in_and_out(tick_node):
    sphere = Sphere(0.02, 1e-4, np.zeros(3), np.ones(3), 50.0, 1.0)
    first = tick_node("own_mean", forces=[1.0], sphere=sphere)
    assert (first.radius, first.seen) == (0.02, Touch(1.0, 0.0))
    assert tick_node("own_mean", forces=[1.0], seen=first.seen).seen == Touch(2.0, 0.0)
    assert tick_node("own_mean", forces=[1.0], sphere={"radius": "30 mm"}).radius == 0.03


def test_a_refusal_and_a_mistake_are_told(tick_node):
    refused = tick_node("own_mean", forces=[])
    assert (refused.status, refused.reason) == ("FAILURE", "there is no force")
    with pytest.raises(
        AttributeError, match="wrote no 'mean'; it wrote nothing; it ended with FAILURE: there is no force"
    ):
        _ = refused.mean
    broken = tick_node("own_mean", forces=[1.0], scale=9.0)
    assert (broken.status, broken.reason) == ("ERROR", "ValueError: nine")
    assert broken.broken[0]["at"].startswith("test_ticked_node.py:") or "test_ticked_node.py" in broken.broken[0]["at"]


def test_devices_are_scripted(tick_node, scripted_device):
    arm = scripted_device("Arm", {"pose": Pose((0.0, 0.0, 0.09))})
    assert tick_node("measure_depth", touch=Touch(0.1, 0.0), arm=arm).depth == pytest.approx(0.01)
    arm = scripted_device("Arm", motion=[MotionState.MOVING, MotionState.BLOCKED])
    result = tick_node("retract", clearance="20 mm", arm=arm)
    assert (result.status, result.ticks) == ("FAILURE", 2)
    assert [command.name for command in arm.commands] == ["move"]
    arm = scripted_device("Arm", {"pose": DeviceLost("arm", "the connection broke")})
    assert tick_node("retract", clearance="20 mm", arm=arm).status == "FAULT"


#: inputs that are wrong, and what is said of them
WRONG = {
    "name": ({"force": []}, r"forces is missing; it takes a list, each a Force"),
    "nearest": ({"forcs": [1.0], "forces": [1.0]}, "no input 'forcs'; did you mean 'forces'?"),
    "output": ({"forces": [1.0], "mean": 1.0}, "mean is an output; the result has it"),
    "unit": ({"forces": ["1 mm"]}, r"forces\[0\] takes Force, but '1 mm' is Length; use one of N, mN, kN"),
    "no unit": ({"forces": [1.0], "wait": "1"}, r"wait: 1 has no unit; write '1 s'"),
    "type": ({"forces": 1.0}, "forces: it takes a list, each a Force"),
    "record": ({"forces": [1.0], "sphere": 3.0}, "sphere: it takes a Sphere or None, not 3.0"),
    "field": ({"forces": [1.0], "sphere": {"radis": "1 mm"}}, "no 'radis'; did you mean 'radius'?"),
    "bounds": ({"forces": [1.0], "scale": 20.0}, "scale: 20 is outside 0.1 to 10"),
    "device": ({"forces": [1.0], "arm": 1}, r'arm: it takes a device, Arm, not 1; give arm=scripted_device\("Arm"\)'),
}


@pytest.mark.parametrize("what", WRONG)
def test_wrong_inputs_are_named_with_what_was_expected(tick_node, what):
    inputs, told = WRONG[what]
    with pytest.raises(InvalidInput, match=told):
        tick_node("own_mean", **inputs)


def test_every_wrong_input_is_named_at_once(tick_node):
    with pytest.raises(InvalidInput) as caught:
        tick_node("measure_depth", touhc=1)
    for told in ("no input 'touhc'", "touch is missing; it takes a Touch", 'give arm=scripted_device("Arm")'):
        assert told in str(caught.value)
    with pytest.raises(InvalidInput, match=r"no node 'own_meen' is registered; did you mean 'own_mean'\?"):
        tick_node("own_meen")


#: fields of a record that do not fit, and what is said of them
WRONG_FIELDS = {
    "ragged": ({"points": [[1.0, 2.0], [3.0]]}, r"contact.points takes an array; write lists of SI numbers, each row"),
    "text": ({"points": "deep"}, "contact.points takes an array"),
    "dtype": ({"labels": np.array([0.5])}, "contact.labels takes an array of uint8, not of float64"),
    "list": ({"noise": [1.0]}, r"contact.noise: it takes a Length \(a finite number, m\), not \[1.0\]"),
    "object": ({"noise": object()}, "contact.noise: it takes a Length"),
    "nan": ({"noise": float("nan")}, "contact.noise: it takes a Length .* not nan"),
    "unit": ({"noise": "1 kg"}, "contact.noise takes Length, but '1 kg' is Mass"),
    "none": ({"noise": None}, "contact.noise: it takes a Length"),
}


@pytest.mark.parametrize("what", WRONG_FIELDS)
def test_fields_of_a_record_are_checked_as_those_of_a_mock_are(tick_node, what):
    fields, told = WRONG_FIELDS[what]
    with pytest.raises(InvalidInput, match=told):
        tick_node("fit_sphere", contact=fields)


def test_a_record_that_its_class_refuses_is_told(tick_node):
    lens = {"fx": -1.0, "fy": 1.0, "cx": 0.0, "cy": 0.0, "width": 4, "height": 3, "distortion": [0.0] * 5}
    with pytest.raises(InvalidInput, match=r"frame.intrinsics: focal lengths are above 0.*; correct the fields"):
        tick_node("detect_contact", frame={"intrinsics": lens})
    with pytest.raises(InvalidInput, match=r"frame: Intrinsics has no 'fz'; known here: cx, "):
        tick_node("detect_contact", frame={"intrinsics": {"fz": 1.0}})


def test_a_field_that_is_read_and_was_not_given_is_named_with_its_port(tick_node):
    result = tick_node("fit_sphere", contact={"noise": "0.1 mm"})
    assert result.status == "ERROR"
    assert result.reason == "the Contact of the test has no 'surface'; give it too, as in contact={'surface': ...}"


LENS = {"fx": 300.0, "fy": 300.0, "cx": 80.0, "cy": 60.0, "width": 160, "height": 120}


def test_all_fields_without_a_default_make_a_whole_record(tick_node):
    frame = {
        "raw": np.full((120, 160), 1500, np.uint16),
        "unit": 1e-4,
        "intrinsics": LENS,
        "time": 0.0,
        "plane_distance": 0.15,
    }
    result = tick_node("segment_contact", frame=frame)
    assert (
        result.reason
        == "the DepthFrame of the test has no 'depth'; it is worked out from all fields: give sequence too"
    )
    result = tick_node("segment_contact", frame={**frame, "sequence": 0})
    assert "has no" not in result.reason


# --- behaviours of py_trees


def test_a_behaviour_of_py_trees_is_ticked_like_a_node(tick_node):
    import py_trees

    counter = py_trees.behaviours.TickCounter
    result = tick_node(counter, duration=2, completion_status="FAILURE")
    assert (result.status, result.ticks) == ("FAILURE", 3)
    by_name = tick_node("py_trees.behaviours.TickCounter", duration=0, completion_status=py_trees.common.Status.SUCCESS)
    assert (by_name.status, by_name.ticks) == ("SUCCESS", 1)


def test_its_ports_are_wired_and_the_blackboard_stays_as_it_was(tick_node):
    import py_trees
    from py_trees.ports import BehaviourWithPorts, PortInformation

    class Doubled(BehaviourWithPorts):
        """Double a number."""

        INPUT_PORTS: ClassVar = {"one": PortInformation(data_type=float, description="a number")}
        OUTPUT_PORTS: ClassVar = {"two": PortInformation(data_type=float, description="twice of it")}

        def update(self):
            self._set_output("two", 2.0 * self.get_input("one"))
            return py_trees.common.Status.SUCCESS

    before = dict(py_trees.blackboard.Blackboard.storage)
    assert tick_node(Doubled, one=1.5).two == 3.0
    assert py_trees.blackboard.Blackboard.storage == before
    with pytest.raises(InvalidInput, match="no input 'on'; did you mean 'one'"):
        tick_node(Doubled, on=1.5)


class Unregistered(Behavior):
    """A node without @node."""


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("py_trees.composites.Sequence", "holds other behaviours.*'sequence' of the language.*tick_task"),
        ("py_trees.behaviours.TickCount", "'TickCount'.*did you mean 'TickCounter'"),
        (Unregistered, "Unregistered is a node that is not registered; put @node above its class"),
        (int, "int is a class, but none of behaviours"),
    ],
)
def test_what_is_no_node_is_refused_with_what_to_do(tick_node, name, told):
    with pytest.raises(InvalidInput, match=told):
        tick_node(name)
