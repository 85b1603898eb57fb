"""What nodes of one's own do with their data: lists of ports are theirs, and outputs are written by the thread of the tree."""

import json

import numpy as np
import pytest

import stretch_bt
from stretch_bt import check
from stretch_bt.errors import InvalidInput, TreeError
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.replay import replay
from stretch_bt.units import Estimate

MODULE = '''
import threading
from stretch_bt import Behavior, In, Out, Status, node
from stretch_bt.tree.ports import Uses
from stretch_bt.hardware.interfaces import Arm

@node
class Appends(Behavior):
    """Appends to its list."""
    instant = True
    ys: In[list[int]] = [1]
    n: Out[int]

    def update(self) -> Status:
        ys = self.ys
        ys.append(2)
        self.n = len(ys)
        return Status.SUCCESS

@node
class Threaded(Behavior):
    """Writes its output in a thread."""
    y: Out[int]

    def initialise(self):
        self.thread = threading.Thread(target=lambda: setattr(self, "y", 3))
        self.thread.start()

    def update(self) -> Status:
        self.thread.join()
        return Status.SUCCESS

@node
class ReadsFirst(Behavior):
    """Reads its output before it wrote it."""
    y: Out[int]

    def update(self) -> Status:
        self.y = self.y + 1
        return Status.SUCCESS

@node
class Slow(Behavior):
    """Says that it is instant, and is not."""
    instant = True

    def update(self) -> Status:
        return Status.RUNNING

@node
class Backwards(Behavior):
    """Asks for a speed that is none."""
    arm: Uses[Arm]

    def update(self) -> Status:
        here = self.arm.pose(1.0).value
        self.arm.move(here, speed=-0.1, owner=self.path)
        return Status.SUCCESS

@node
class Empty(Behavior):
    """Does nothing."""
'''


@pytest.fixture
def written(tmp_path, own_nodes, request):
    """Write a tree beside the module, whose name no other test has."""
    name = f"own_data_{abs(hash(request.node.name))}"
    (tmp_path / f"{name}.py").write_text(MODULE)

    def write(text):
        (tmp_path / "tree.yaml").write_text(f"format: stretch-tree/1\nimports: {{own: {name}}}\n{text}")
        return tmp_path / "tree.yaml"

    return write


def test_a_list_that_a_node_changes_is_its_own(run, tmp_path, written):
    text = """
params: {p: {type: 'list[int]', default: [1, 2]}}
trees: {main: {out: [n, m, p2], sequence: [appends: {ys: $p, n: $n}, appends: {n: $m}, set: {p2: p}]}}
"""
    for _ in range(2):
        outputs = run(written(text), modules=tmp_path).outputs
        assert [outputs[name]["value"] for name in ("n", "m", "p2")] == [3, 2, [1, 2]]


def test_an_output_is_not_written_by_another_thread(run, tmp_path, written):
    result = run(written("trees: {main: {out: [y], sequence: [threaded: {y: $y}]}}\n"), modules=tmp_path)
    assert result.status == "ERROR"
    assert "wrote 'y' in another thread" in json.dumps(result.broken)
    assert ["another thread" in error for error in result.errors] == [True]  # and the record is whole


def test_a_node_without_an_update_is_found_before_a_run(run, written):
    path = written("trees: {main: {sequence: [empty]}}\n")
    assert [found.message for found in check(path)] == ["Empty does not override update()"]
    with pytest.raises(TreeError) as refused:
        run(path, modules=path.parent)
    assert [found.message for found in refused.value.diagnostics] == ["Empty does not override update()"]


def test_arrays_of_numpy_are_readings_and_params(run):
    text = """
format: stretch-tree/1
devices: {arm: Arm}
params: {ds: {type: 'list[Length]', default: [1 mm]}}
trees: {main: {sequence: [check: arm.force < 2 N, check: 'arm.force > 2 N and at(ds, 1) == 3 mm']}}
"""
    result = run(text, mocks={"readings": {"arm.force": np.array([1.0, 3.0])}}, params={"ds": np.array([0.001, 0.003])})
    assert result.status == "SUCCESS", result.reason


@pytest.mark.parametrize("seed", [-1, 1.5, None, "3", True])
def test_a_seed_is_a_whole_number(seed):
    with pytest.raises(InvalidInput, match="a seed is a whole number from 0 on"):
        stretch_bt.open_cell(scene="water_balloon", seed=seed)


def test_a_seed_may_be_one_of_numpy(run):
    assert (
        run("format: stretch-tree/1\ntrees: {main: {sequence: [check: 1 < 2]}}\n", seed=np.int64(3)).status == "SUCCESS"
    )


def test_a_wrong_call_of_a_device_is_the_same_in_a_replay_and_has_its_line(run, tmp_path, own_nodes):
    text = """
from stretch_bt import Behavior, Status, Uses, node
from stretch_bt.errors import InvalidInput
from stretch_bt.runtime.replay import replay
from stretch_bt.hardware.interfaces import Arm

@node
class NoOwner(Behavior):
    "Moves without an owner."
    arm: Uses[Arm]
    def update(self): self.arm.move(self.arm.pose(0.2).value, speed=0.05)

@node
class Refuses(Behavior):
    "Raises an error of the package."
    def update(self): raise InvalidInput("boom")
"""
    (tmp_path / "own_calls_of.py").write_text(text)
    for name, said, line in (("no_owner", "MonitoredArm.move() missing", 11), ("refuses", "boom", 16)):
        path = tmp_path / "tree.yaml"
        head = "format: stretch-tree/1\nimports: {own: own_calls_of}\ndevices: {arm: Arm}\nscene: water_balloon\n"
        path.write_text(f"{head}trees: {{main: {{sequence: [{name}]}}}}\n")
        result = run(path, modules=tmp_path, out=tmp_path / name)
        assert result.status == "ERROR"
        assert said in result.reason
        assert [broken["at"].rpartition("/")[2] for broken in result.broken] == [f"own_calls_of.py:{line} in update"]
        assert replay(result.record, trust=True).identical


@pytest.mark.parametrize(
    ("name", "why"),
    [("reads_first", "read its output 'y' before it wrote it"), ("slow", "returned RUNNING, though it is instant")],
)
def test_what_a_node_does_against_its_ports_is_told(written, tmp_path, name, why):
    result = stretch_bt.run(written(f"trees: {{main: {{sequence: [{name}]}}}}"), out=tmp_path / "r")
    assert result.status == "ERROR"
    assert why in result.reason


@pytest.mark.parametrize(
    ("name", "taken"), [("Sequence", "construct"), ("Finally", "construct"), ("Approach", "shipped tree")]
)
def test_a_node_that_no_tree_could_name_is_told_at_its_import(tmp_path, own_nodes, name, taken):
    module = f"own_name_{name.lower()}"
    (tmp_path / f"{module}.py").write_text(
        MODULE.partition("@node")[0]
        + f'@node\nclass {name}(Behavior):\n    """One."""\n    def update(self):\n        return Status.SUCCESS\n'
    )
    (tmp_path / "tree.yaml").write_text(
        f"format: stretch-tree/1\nimports: {{own: {module}}}\ntrees: {{main: {{sequence: [wait: {{duration: 1 s}}]}}}}\n"
    )
    (found,) = check(tmp_path / "tree.yaml")
    assert (found.line, found.column, found.code) == (2, 11, "name")
    assert f"the name of a {taken}" in found.message
    assert f"My{name}" in found.hint


def test_a_command_whose_numbers_are_none_replays_as_it_was_refused(written, tmp_path):
    text = "devices: {arm: Arm}\nscene: water_balloon\ntrees: {main: {sequence: [backwards]}}"
    result = stretch_bt.run(written(text), out=tmp_path / "r")
    assert "speed must be finite and above 0 m/s, not -0.1" in result.reason
    assert replay(tmp_path / "r", trust=True).identical


#: what a caller in Python has for a param -> what the tree has
GIVEN = [
    ("d", np.float64(0.004), 0.004),
    ("d", np.float32(0.25), 0.25),
    ("d", np.int64(2), 2.0),
    ("d", Estimate(0.004, 0.001), 0.004),
    ("d", None, None),
    ("x", Estimate(0.5, 0.1), 0.5),
    ("x", np.float64(1e-7), 1e-7),
    ("ds", np.array([0.004, 0.006]), [0.004, 0.006]),
    ("ds", np.array([4, 6]), [4.0, 6.0]),
    ("ds", (0.004, 0.006), [0.004, 0.006]),
    ("ds", list(np.linspace(0.0, 0.5, 3)), [0.0, 0.25, 0.5]),
    ("ds", [Estimate(0.004, 0.001)], [0.004]),
    ("ds", None, None),
    ("yes", np.bool_(True), True),
]


@pytest.mark.parametrize(("name", "given", "held"), GIVEN)
def test_a_param_of_numpy_or_a_node_is_the_number_and_replays(tmp_path, name, given, held):
    (tmp_path / "tree.yaml").write_text("""\
format: stretch-tree/1
params:
  d: {type: Length, default: none}
  ds: {type: 'list[Length]', default: none}
  x: {type: float, default: 1}
  yes: {type: bool, default: false}
trees: {main: {sequence: [check: task.time >= 0 s]}}
""")
    result = stretch_bt.run(tmp_path / "tree.yaml", params={name: given}, out=tmp_path / "record")
    assert result.status == "SUCCESS"
    record = RecordReader(tmp_path / "record")
    assert record.header["params"][name] == held
    assert replay(tmp_path / "record").identical
