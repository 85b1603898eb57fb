"""Behaviours of other packages in a run: their inputs and outputs, when they are set up and shut down, and what remains of them."""

import re
import sys
import time

import py_trees
import pytest
from jsonschema import Draft7Validator
from py_trees.blackboard import Blackboard

from stretch_bt import check, run
from stretch_bt.errors import StretchError, TreeError
from stretch_bt.runtime.replay.again import replay
from stretch_bt.tree.node_description import describe
from stretch_bt.tree.program import load_program
from stretch_bt.tree.schema import schema

MODULE = '''
import py_trees
from py_trees.common import Status
from py_trees.ports import BehaviourWithPorts, PortInformation
from stretch_bt.units import Length

LOG = []
MADE = []


class Notes(py_trees.behaviour.Behaviour):
    """Notes what is done to it.

    Args:
        name: of the behaviour
        breaks: the method that raises
        ticks (int): until it ends
    """

    def __init__(self, name: str, breaks: str = "", ticks: int = 1, reach: Length = 0.1, timeout: float = 1.0):
        super().__init__(name)
        MADE.append(self)
        self.breaks, self.ticks, self.reach, self.timeout = breaks, ticks, reach, timeout
        self.note("init")

    def note(self, what):
        LOG.append(f"{self.name}.{what}")
        if what == self.breaks:
            raise ValueError(f"{what} is broken")

    def setup(self, **kwargs):
        self.note("setup")

    def initialise(self):
        self.note("initialise")
        self.left = self.ticks

    def update(self):
        self.note("update")
        self.left -= 1
        return Status.RUNNING if self.left else Status.SUCCESS

    def terminate(self, new_status):
        self.note(f"terminate({new_status.name})")

    def shutdown(self):
        self.note("shutdown")


class Pair(py_trees.composites.Sequence):
    """Two in a row."""

    def __init__(self, name: str):
        super().__init__(name, memory=True)
        self.add_children([Notes("first"), Notes("second", ticks=2)])


class Scale(BehaviourWithPorts, register=False):
    """Multiply a length."""

    INPUT_PORTS = {
        "length": PortInformation(data_type=float, description="to be multiplied"),
        "factor": PortInformation(data_type=float, default_value=2.0),
        "unit": PortInformation(data_type=str, required=False),
    }
    OUTPUT_PORTS = {
        "product": PortInformation(data_type=float),
        "text": PortInformation(data_type=str, required=False),
    }

    def __init__(self, name: str, digits: int = 3):
        super().__init__(name=name)
        self.digits = digits

    def update(self):
        self._set_output("product", round(self.get_input("length") * self.get_input("factor"), self.digits))
        if self.get_input("unit", "") == "m":
            self._set_output("text", "in metres")
        return Status.SUCCESS


class Silent(BehaviourWithPorts, register=False):
    """Writes nothing."""

    INPUT_PORTS = {}
    OUTPUT_PORTS = {"value": PortInformation(data_type=int)}

    def update(self):
        return Status.SUCCESS


class Lost(py_trees.behaviour.Behaviour):
    def __init__(self):
        pass

    def update(self):
        return Status.SUCCESS


class Nothing(py_trees.behaviour.Behaviour):
    def __init__(self):
        super().__init__("nothing")

    def update(self):
        pass
'''
TREE = "format: stretch-tree/1\ntick: 1 ms\nimports: {imports}\ntrees:\n  main:\n{body}"


@pytest.fixture
def own(tmp_path):
    """Return a function that runs a body of `main` with classes of an own module; `own.module` is that module."""

    def run_body(body, imports="{own: own_behaviours}", **options):
        return run(write(body, imports), out=tmp_path / f"record{next(count)}", **options)

    def write(body, imports="{own: own_behaviours}"):
        lines = "".join(f"    {line}\n" for line in body.strip().splitlines())
        path = tmp_path / "tree.yaml"
        path.write_text(TREE.format(imports=imports, body=lines))
        return path

    count = iter(range(1000))
    (tmp_path / "own_behaviours.py").write_text(MODULE)
    sys.modules.pop("own_behaviours", None)
    run_body.write = write
    run_body.log = lambda: sys.modules["own_behaviours"].LOG
    run_body.made = lambda: sys.modules["own_behaviours"].MADE
    yield run_body
    sys.modules.pop("own_behaviours", None)


def test_a_behaviour_has_a_life_of_one_instance_a_place(own):
    result = own("sequence:\n  - own.Notes\n  - {own.Notes: {ticks: 2}, name: twice}\n  - own.Notes")
    assert result.status == "SUCCESS"
    names = [made.name for made in own.made()]
    assert len(set(names)) == 3
    assert "twice" in names
    first = names[0]
    assert [line for line in own.log() if line.startswith(f"{first}.")] == [
        f"{first}.{what}" for what in ("init", "setup", "initialise", "update", "terminate(SUCCESS)", "shutdown")
    ]
    setups = [line for line in own.log() if line.endswith("setup")]
    assert own.log()[len(names) : 2 * len(names)] == setups  # all of them before the first tick
    assert [line.partition(".")[0] for line in own.log()[-3:]] == names[::-1]


def test_one_that_is_interrupted_is_told_once(own):
    own("force_success:\n  timeout: {after: 3 ms, do: {own.Notes: {ticks: 100}}}")
    assert [line for line in own.log() if "terminate" in line] == ["notes.terminate(INVALID)"]
    assert own.log()[-1] == "notes.shutdown"


def test_a_composite_of_another_package_is_one_node(own):
    result = own("own.Pair")
    assert result.status == "SUCCESS"
    assert result.visited == {"main/pair": ("RUNNING", "SUCCESS")}
    assert [line for line in own.log() if "setup" in line or "shutdown" in line] == [
        "first.setup",
        "second.setup",
        "first.shutdown",
        "second.shutdown",
    ]


def test_arguments_come_from_literals_and_params_in_si(own):
    own("own.Notes: {reach: 20 mm, ticks: 2, timeout: 0.5}")
    [made] = own.made()
    assert (made.reach, made.ticks, made.timeout) == (0.02, 2, 0.5)


def test_a_class_alone_is_imported_by_its_name(own):
    assert own("notes: {ticks: 2}", "{notes: own_behaviours.Notes}").visited == {"main/notes": ("RUNNING", "SUCCESS")}


@pytest.mark.parametrize(
    ("breaks", "ticks"),
    [("init", 1), ("setup", 1), ("initialise", 1), ("update", 1), ("terminate(SUCCESS)", 1), ("shutdown", 1)],
)
def test_what_breaks_names_the_node_and_is_followed_by_its_shutdown(own, breaks, ticks):
    body = f"sequence:\n  - {{own.Notes: {{}}, name: sound}}\n  - own.Notes: {{breaks: {breaks!r}}}"
    if breaks == "init":
        with pytest.raises(StretchError, match=r"main/notes: Notes\(\) broke \(ValueError: init is broken\)"):
            own(body)
        assert own.log() == ["sound.init", "notes.init"]
        return
    result = own(body)
    assert result.status == "ERROR"
    assert "main/notes: " in result.reason
    assert f"{breaks} is broken" in result.reason
    assert {"sound.shutdown", "notes.shutdown"} <= set(own.log())
    assert any("own_behaviours.py:" in broken["at"] for broken in result.broken)


@pytest.mark.parametrize(
    ("name", "said"),
    [("Nothing", "main/nothing: update\\(\\) returned .*INVALID"), ("Lost", "begin its __init__ with super")],
)
def test_one_that_keeps_no_contract_is_told(own, name, said):
    try:
        reason = own(f"own.{name}").reason
    except StretchError as error:  # before any device is opened
        reason = str(error)
    assert re.search(said, reason)


def test_declared_ports_go_through_keys(own):
    body = """
out: {product: float, again: float}
sequence:
  - own.Scale: {length: 1, unit: m, digits: 1, product, text: $said}
  - check: {that: "said == 'in metres'"}
  - own.Scale: {length: $product, factor: 3, product: $again, text: $quiet}
  - check: {that: quiet == none}
"""
    result = own(body)
    assert result.status == "SUCCESS", result.reason
    assert {name: value["value"] for name, value in result.outputs.items()} == {"product": 2.0, "again": 6.0}


def test_a_declared_output_that_is_not_written_is_told(own):
    result = own("own.Silent: {value: $x}")
    assert result.status == "ERROR"
    assert "main/silent: ended with SUCCESS without writing 'value'" in result.reason


def test_a_mock_stands_in_for_it_and_nothing_is_paced(own, tmp_path):
    mocks = {"mocks": [{"match": "main/notes", "status": "success", "after": "15 s"}]}
    tree = own.write("own.Notes")
    before = time.monotonic()
    result = run(tree, mocks={"format": "stretch-mocks/1", **mocks}, out=tmp_path / "mocked")
    assert (result.status, own.made()) == ("SUCCESS", [])
    assert result.task_seconds > time.monotonic() - before


# --- the clock


def test_a_run_goes_no_faster_than_the_clock_of_the_machine(own):
    before = time.monotonic()
    result = own("timer: {duration: 0.2}", "{timer: py_trees.timers.Timer}")
    assert result.status == "SUCCESS"
    assert result.task_seconds <= time.monotonic() - before
    assert result.ticks <= 1 + 1000 * (time.monotonic() - before)  # as many as fit, one each millisecond


def test_a_wait_of_ours_beside_it_takes_its_time_too(own):
    before = time.monotonic()
    own("sequence:\n  - pb.Success\n  - wait: {duration: 150 ms}", "{pb: py_trees.behaviours}")
    assert time.monotonic() - before >= 0.15


# --- signals


@pytest.mark.parametrize("method", ["setup", "update", "shutdown"])
def test_a_signal_cuts_off_one_that_hangs(own, tmp_path, method):
    hangs = f"""
import os, signal, threading, time
import py_trees

class Hangs(py_trees.behaviour.Behaviour):
    def __init__(self, name: str):
        super().__init__(name)

    def update(self):
        return py_trees.common.Status.SUCCESS

def hang(self, *args, **kwargs):
    threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
    time.sleep(60)

Hangs.{method} = hang
"""
    (tmp_path / "own_hangs.py").write_text(hangs)
    sys.modules.pop("own_hangs", None)
    before = time.monotonic()
    result = own("own.Hangs", "{own: own_hangs}")
    sys.modules.pop("own_hangs", None)
    assert time.monotonic() - before < 20
    assert result.status == "INTERRUPTED"
    assert "main/hangs: its code did not return" in f"{result.reason} {result.errors}"


# --- the Blackboard


@pytest.fixture
def board():
    Blackboard.clear()
    yield Blackboard
    Blackboard.clear()


def state():
    about = {key: (set(data.read), set(data.write)) for key, data in Blackboard.metadata.items()}
    return dict(Blackboard.storage), about, dict(Blackboard.clients)


PUT = "pb.SetBlackboardVariable: {variable_name: seen, variable_value: 3, overwrite: true}"
LOOK = "pb.CheckBlackboardVariableExists: {variable_name: seen}"
PB = "{pb: py_trees.behaviours}"


def test_a_value_of_one_run_is_not_there_in_the_next(own, board):
    assert own(f"sequence:\n  - {PUT}\n  - {LOOK}", PB).status == "SUCCESS"
    assert own(LOOK, PB).status == "FAILURE"


def test_the_blackboard_ends_as_it_began_and_shows_what_was_there(own, board):
    client = py_trees.blackboard.Client(name="caller")
    client.register_key(key="seen", access=py_trees.common.Access.WRITE)
    client.seen = "by the caller"
    before = state()
    assert own(LOOK, PB).status == "SUCCESS"
    assert own(f"sequence:\n  - {PUT}\n  - pb.UnsetBlackboardVariable: {{key: seen}}", PB).status == "SUCCESS"
    assert state() == before
    client.seen = "still writable"
    assert board.get("seen") == "still writable"


def test_a_run_inside_a_run_leaves_the_outer_one_its_values(own, board, tmp_path):
    inner = tmp_path / "inner.yaml"
    inner.write_text(TREE.format(imports=PB, body=f"    sequence:\n      - {LOOK}\n      - {PUT}\n"))
    (tmp_path / "own_nested.py").write_text(f"""
import py_trees
import stretch_bt

class Nested(py_trees.behaviour.Behaviour):
    def __init__(self, name: str):
        super().__init__(name)

    def update(self):
        result = stretch_bt.run({str(inner)!r}, out={str(tmp_path / "inner")!r})
        return py_trees.common.Status[result.status]
""")
    body = f"sequence:\n  - {PUT.replace('3', 'outer')}\n  - nest.Nested\n  - {LOOK}"
    result = own(body, "{pb: py_trees.behaviours, nest: own_nested}")
    sys.modules.pop("own_nested", None)
    assert result.status == "SUCCESS", result.reason
    assert board.storage == {}


def test_check_leaves_nothing_on_the_blackboard_and_tells_what_a_class_refuses(own, board):
    tree = own.write(f"sequence:\n  - {LOOK}\n  - pb.ProbabilisticBehaviour: {{weights: [1, 2]}}", PB)
    [found] = check(tree)
    assert (found.code, found.line) == ("argument", 8)
    assert "ValueError: Either all or none of the probabilities" in found.message
    assert state() == ({}, {}, {})


# --- messages of check for a tree


@pytest.mark.parametrize(
    ("imports", "body", "column", "said"),
    [
        ("{n: own_behaviours.Nots}", "n", 14, "module 'own_behaviours' has no 'Nots'; did you mean 'Notes'?"),
        ("{wait: own_behaviours.Notes}", "wait: {duration: 1 s}", 11, "has the name of a node"),
        ("{n: own_behaviours.LOG}", "n", 14, "neither a module nor a class"),
        ("{own: own_behaviours}", "own.Nots", 5, "did you mean 'own.Notes'?"),
        ("{own: own_behaviours}", "own.Notes: {tick: 3}", 17, "did you mean 'ticks'?"),
        ("{own: own_behaviours}", "own.Notes: {ticks: 1.5}", 24, "takes int"),
        ("{own: own_behaviours}", "own.Notes: {reach: 0.5}", 24, "has no unit"),
        ("{own: own_behaviours}", "sequence: [set: {k: 1}, own.Notes: {ticks: $k}]", 48, "must be known at load"),
        ("{own: own_behaviours}", "own.Scale: {product: $x}", 5, "needs 'length' (float)"),
    ],
)
def test_a_mistake_has_its_place_and_a_remedy(own, imports, body, column, said):
    try:
        found = check(own.write(body, imports))
    except TreeError as error:
        found = error.diagnostics
    errors = [d for d in found if d.severity == "error"]
    assert any(said in str(d) for d in errors), errors
    assert any(d.column in (column, column + 1) for d in errors if said in str(d)), errors


def test_the_docstring_tells_of_the_arguments(own):
    program = load_program(own.write("n", "{n: own_behaviours.Notes, scale: own_behaviours.Scale}"))
    told = describe(program.document.classes["n"])
    assert (told["doc"], told["module"]) == ("Notes what is done to it.", "own_behaviours")
    assert {port["name"]: port["doc"] for port in told["inputs"]} == {
        "breaks": "the method that raises",
        "ticks": "until it ends",
        "reach": "",
        "timeout": "",
    }
    ports = describe(program.document.classes["scale"])
    assert [port["name"] for port in ports["inputs"] if port["required"]] == ["length"]
    assert [port["name"] for port in ports["outputs"]][:1] == ["product"]


def test_the_schema_of_a_tree_holds_its_own_nodes(own):
    nodes = load_program(own.write("n", "{n: own_behaviours.Notes, pb: py_trees.behaviours}")).document.classes
    made = schema("tree", nodes)
    good = {
        "format": "stretch-tree/1",
        "imports": {"n": "own_behaviours.Notes"},
        "trees": {"main": {"n": {"ticks": 2}}},
    }
    Draft7Validator(made).validate(good)
    for wrong in ({"tick": 2}, {"ticks": 1.5}, {"reach": 0.5}):
        assert not Draft7Validator(made).is_valid({**good, "trees": {"main": {"n": wrong}}}), wrong
    assert "node_n" not in schema("tree")["$defs"]


def test_the_twin_goes_with_the_clock_of_the_machine(own, tmp_path):
    tree = tmp_path / "twin.yaml"
    tree.write_text("""\
format: stretch-tree/1
imports: {timer: py_trees.timers.Timer}
devices: {gripper: Gripper, arm: Arm}
scene: water_balloon
trees:
  main:
    parallel:
      - set_stretch: {stretch: 3 mm, speed: 20 mm/s}
      - timer: {duration: 0.1}
""")
    result = run(tree, out=tmp_path / "record")
    assert result.status == "SUCCESS"
    assert 0.1 <= result.task_seconds <= result.wall_seconds
    assert replay(tmp_path / "record").identical
