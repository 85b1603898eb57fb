"""The nodes of a characterisation, each on scripted devices."""

import json
import math
from functools import partial

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.limits import Limits, Span
from stretch_bt.model.characterization import NAME, read_table
from stretch_bt.run.context import RunContext
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import Role, Status
from stretch_bt.tree.registry import lookup

TOUCHED = 0.060


class Sensor:
    """A force sensor that says what it is told, with the number of each reading; the last one stays."""

    def __init__(self, forces, numbers=None):
        self.forces, self.numbers, self.now, self.zeroed = list(forces), numbers, lambda: 0.0, 0
        self.read = -1

    def wrench(self, max_age):
        self.read += 1
        number = self.read if self.numbers is None else self.numbers[min(self.read, len(self.numbers) - 1)]
        force = self.forces[min(self.read, len(self.forces) - 1)]
        return Reading(Wrench(force if isinstance(force, tuple) else (0.0, 0.0, force)), self.now(), self.now(), number)

    def zero(self):
        self.zeroed += 1


class Bench:
    """A run of single nodes: one context, a clock, and devices that stay from node to node."""

    def __init__(self, folder, **devices):
        self.context = RunContext()
        self.context.folder = folder
        self.context.about = {"scene": "calibration_sphere", "seed": 4, "versions": {}}
        self.context.hand.contact_height = TOUCHED
        for device in devices.values():
            device.now = lambda: self.context.now
        self.context.devices = {
            "arm": ScriptedDevice("Arm", {"pose": Pose((0.0, 0.0, TOUCHED))}),
            "gripper": ScriptedDevice("Gripper", {"opening": 0.065}),
            **devices,
        }

    def stand(self, height, rotation=(0.0, 0.0, 0.0)):
        self.context.devices["arm"] = ScriptedDevice("Arm", {"pose": Pose((0.0, 0.0, height), rotation)})

    def node(self, name, **inputs):
        info = lookup(name)
        node = info.cls(f"main/{name}")
        node.context = self.context
        node.device_names = {p.name: p.name for p in info.of(Role.DEVICE)}
        for port in info.of(Role.INPUT):
            node.wiring[port.name] = partial(inputs.get, port.name, port.default)
        return node

    def tick(self, node, times=1):
        for _ in range(times):
            for _ in node.tick():
                pass
            self.context.now += 0.05
        return node.status

    def run(self, name, **inputs):
        node = self.node(name, **inputs)
        while self.tick(node) is Status.RUNNING:
            assert self.context.now < 100.0
        return node


@pytest.fixture
def bench(tmp_path):
    return partial(Bench, tmp_path)


def force_of(node):
    return node.sinks["force"].value, node.sinks["force"].sd


# --- forces


def test_a_force_is_the_mean_along_the_axis_with_its_standard_error(bench):
    sensor = Sensor([(0.3, 0.0, 1.0), (0.1, 0.2, 1.2), (0.0, 0.0, 1.4), (0.0, 0.0, 99.0)])
    node = bench(force_sensor=sensor).run("measure_force", count=3)
    assert force_of(node) == pytest.approx((1.2, 0.2 / math.sqrt(3)))


def test_the_axis_is_that_of_the_hand(bench):
    made = bench(force_sensor=Sensor([(0.0, -1.0, 0.0), (0.0, -1.2, 0.0)]))
    made.stand(0.055, rotation=(math.pi / 2, 0.0, 0.0))
    assert force_of(made.run("measure_force", count=2))[0] == pytest.approx(1.1)


def test_noise_does_not_raise_the_force_of_nothing(bench):
    node = bench(force_sensor=Sensor([(0.1, -0.1, 0.02), (-0.1, 0.1, -0.02)])).run("measure_force", count=2)
    assert force_of(node) == pytest.approx((0.0, 0.02))


def test_a_reading_counts_once(bench):
    made = bench(force_sensor=Sensor([1.0, 5.0, 5.0, 2.0], numbers=[7, 7, 7, 8]))
    node = made.node("measure_force", count=2)
    assert made.tick(node, 3) is Status.RUNNING
    assert made.tick(node) is Status.SUCCESS
    assert force_of(node)[0] == pytest.approx(1.5)


def test_a_reading_from_before_does_not_count(bench):
    sensor = Sensor([1.0, 2.0, 3.0])
    made = bench(force_sensor=sensor)
    made.context.now, sensor.now = 5.0, lambda: 4.9
    node = made.node("measure_force", count=1)
    assert made.tick(node) is Status.RUNNING
    sensor.now = lambda: 6.0
    assert made.tick(node) is Status.SUCCESS
    assert force_of(node) == (2.0, 0.0)


def test_what_is_left_after_zeroing_is_taken_off_with_its_error(bench):
    sensor = Sensor([0.1, 0.3, 1.0, 1.0, 1.6])
    made = bench(force_sensor=sensor)
    zero = made.run("zero_force", count=2)
    assert (sensor.zeroed, zero.sinks["offset"].value) == (1, pytest.approx(0.2))
    force = force_of(made.run("measure_force", count=3))
    assert force == pytest.approx((1.0, math.hypot(0.1, 0.2)))


def test_a_sensor_without_new_readings_is_refused(bench):
    node = bench(force_sensor=Sensor([1.0], numbers=[3])).run("measure_force", count=5)
    assert node.status is Status.FAILURE
    assert node.reason == "the force sensor has had no new reading for 1 s; look after it"


STUCK = "the force sensor says 0.5 N to the last digit at two depths, so that it is stuck; look after it"


@pytest.mark.parametrize(
    ("before", "after", "heights", "stuck"),
    [
        ([0.5], [0.5], (0.056, 0.055), True),
        ([0.5], [0.5], (0.080, 0.055), True),
        ([0.5], [0.5], (0.055, 0.055), False),
        ([0.5], [0.5], (0.080, 0.0595), False),
        ([0.4], [0.5], (0.056, 0.055), False),
        ([0.5, 0.51], [0.5], (0.056, 0.055), False),
        ([0.5], [0.5, 0.51], (0.056, 0.055), False),
    ],
    ids=["pressed deeper", "from the air", "same depth", "no contact", "moved once", "noise before", "noise now"],
)
def test_a_sensor_that_says_one_force_everywhere_is_stuck(bench, before, after, heights, stuck):
    made = bench(force_sensor=Sensor(before * 2))
    made.stand(heights[0])
    made.run("measure_force", count=len(before))
    made.stand(heights[1])
    made.context.devices["force_sensor"].forces = after * 4
    node = made.run("measure_force", count=3)
    assert (node.status, node.reason) == ((Status.FAILURE, STUCK) if stuck else (Status.SUCCESS, ""))


# --- the operator


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


# --- the table

SMALL = {"diameters": [0.02, 0.03], "stretches": [0.0, 0.01], "depths": [0.0, 0.002], "trials": 1}


def told(node):
    names = ("geometry", "diameter", "stretch", "depth", "trial", "new_indenter", "new_trial", "rows")
    return tuple(node.sinks[name].value for name in names)


def write(made, state, **more):
    """Stand where a state wants the hand, and write its row."""
    made.stand(TOUCHED - state.sinks["depth"].value)
    made.context.devices["gripper"] = ScriptedDevice("Gripper", {"opening": 0.055 + state.sinks["stretch"].value})
    inputs = {name: state.sinks[name].value for name in ("geometry", "diameter", "angle", "trial")}
    return made.run("write_row", force=0.5, force_sd=0.01, **inputs, **more)


def measure(made, rows=None, **inputs):
    """Measure until it is done, or some rows were written; return what was told before each row."""
    node, seen = made.node("next_state", **{**SMALL, **inputs}), []
    while True:
        assert made.tick(node) is Status.SUCCESS
        if node.sinks["done"].value or len(seen) == rows:
            return node, seen
        seen.append(told(node))
        assert write(made, node, table=inputs.get("table", "")).status is Status.SUCCESS


def test_states_come_in_the_order_of_the_protocol(bench):
    _, seen = measure(bench())
    assert seen == [
        ("sphere", 0.02, 0.0, 0.0, 1, True, True, 0),
        ("sphere", 0.02, 0.0, 0.002, 1, False, False, 1),
        ("sphere", 0.02, 0.01, 0.0, 1, False, True, 2),
        ("sphere", 0.02, 0.01, 0.002, 1, False, False, 3),
        ("sphere", 0.03, 0.0, 0.0, 1, True, True, 4),
        ("sphere", 0.03, 0.0, 0.002, 1, False, False, 5),
        ("sphere", 0.03, 0.01, 0.0, 1, False, True, 6),
        ("sphere", 0.03, 0.01, 0.002, 1, False, False, 7),
    ]


def test_a_state_stays_until_its_row_is_written(bench):
    made = bench()
    node = made.node("next_state", **SMALL)
    made.tick(node)
    first = told(node)
    made.tick(node)
    assert told(node) == (*first[:5], False, False, 0)
    write(made, node)
    made.tick(node)
    assert told(node)[3] == 0.002


def test_rows_hold_what_was_measured_and_where(bench, tmp_path):
    made = bench()
    made.context.now = 7.0
    measure(made, rows=2)
    table = read_table(tmp_path / NAME)
    assert table.provenance["protocol"] == "tasks"
    assert (table.provenance["scene"], table.provenance["seed"], table.provenance["cell"]) == (
        "calibration_sphere",
        4,
        "simulated",
    )
    assert table.provenance["hand"]["gauge"] == 0.1
    assert table.depth.tolist() == pytest.approx([0.0, 0.002])
    assert table.contact_height.tolist() == [TOUCHED, TOUCHED]
    assert table.force_sd.tolist() == [0.01, 0.01]
    assert 7.0 <= table.time[0] < table.time[1] < 8.0


def test_a_cone_has_an_angle(bench, tmp_path):
    made = bench()
    node = made.node("next_state", **{**SMALL, "protocol": "paper"})
    made.tick(node)
    seen = set()
    while not node.sinks["done"].value:
        seen.add((node.sinks["geometry"].value, node.sinks["diameter"].value, node.sinks["angle"].value))
        write(made, node)
        made.tick(node)
    assert seen == {
        *(("sphere", d, 0.0) for d in (0.02, 0.03)),
        *(("cylinder", d, 0.0) for d in (0.02, 0.03)),
        ("cone", 0.0, math.radians(45)),
    }
    assert read_table(tmp_path / NAME).size[-1] == pytest.approx(math.radians(45))


def table_of(path):
    return [(p.geometry, p.size, p.stretch, p.depth, p.trial) for p in read_table(path).presses()]


@pytest.mark.parametrize("rows", range(9))
@pytest.mark.parametrize("torn", ["", "sphere,20,,0", "sphere,20,,0,2,1,0.5,0.01,60,1"])
def test_an_interrupted_table_is_gone_on_with(tmp_path, rows, torn):
    whole = Bench(tmp_path / "whole")
    whole.context.folder.mkdir()
    measure(whole)
    first = Bench(tmp_path / "first")
    first.context.folder.mkdir()
    measure(first, rows=rows)
    table = first.context.folder / NAME
    with table.open("a") as file:
        file.write(torn)
    second = Bench(tmp_path / "second")
    second.context.folder.mkdir()
    _, seen = measure(second, table=str(table))
    assert len(seen) == 8 - rows
    assert not seen or seen[0][5:] == (True, True, rows)
    assert table_of(table) == table_of(whole.context.folder / NAME) == table_of(second.context.folder / NAME)


@pytest.mark.parametrize("kept", [0, 1, 30, 200])
def test_a_table_that_was_cut_in_its_head_begins_anew(bench, tmp_path, kept):
    whole = bench()
    whole.context.folder = tmp_path / "record"
    whole.context.folder.mkdir()
    measure(whole, rows=0)
    table = tmp_path / "table.csv"
    table.write_text((tmp_path / "record" / NAME).read_text()[:kept])
    measure(bench(), table=str(table))
    assert len(read_table(table)) == 8


@pytest.mark.parametrize("text", ["a,b\n1,2\n", "a,b", "# stretch-other\n1\n"])
def test_another_file_is_never_written_over(bench, tmp_path, text):
    path = tmp_path / "notes.csv"
    path.write_text(text)
    node = bench().node("next_state", table=str(path), **SMALL)
    with pytest.raises(InvalidInput, match=r"notes\.csv:1: a table begins with"):
        next(iter(node.tick()))
    assert path.read_text() == text


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"scene": "wire_circle"},
            "is of scene 'calibration_sphere', this run is of 'wire_circle'; name another table",
        ),
        ({"cell": "mine.yaml"}, "is of cell 'simulated', this run is of 'mine.yaml'"),
        ({"seed": 9}, None),
    ],
)
def test_a_table_of_something_else_is_refused(bench, tmp_path, change, said):
    measure(bench(), rows=1, table=str(tmp_path / "table.csv"))
    made = bench()
    made.context.about = {**made.context.about, **change}
    node = made.run("next_state", table=str(tmp_path / "table.csv"), **SMALL)
    assert node.status is (Status.FAILURE if said else Status.SUCCESS)
    assert (said or "") in node.reason
    assert len(read_table(tmp_path / "table.csv")) == 1


def test_a_table_of_another_protocol_is_refused(bench, tmp_path):
    measure(bench(), rows=1, table=str(tmp_path / "table.csv"))
    node = bench().run("next_state", protocol="paper", table=str(tmp_path / "table.csv"))
    assert "the table is of protocol 'tasks', this run is of 'paper'" in node.reason


@pytest.mark.parametrize(
    ("first", "second", "said"),
    [
        ({"condition": True}, {"condition": True}, None),
        ({}, {}, None),
        (
            {"condition": True},
            {},
            "conditioned to a stretch of 10 mm and a depth of 2 mm, that of this run not conditioned",
        ),
        ({}, {"condition": True}, "not conditioned, that of this run conditioned to a stretch of 10 mm"),
        (
            {"condition": True},
            {"condition": True, "stretches": [0.0, 0.02]},
            "that of this run conditioned to a stretch of 20 mm",
        ),
    ],
)
def test_a_table_of_a_membrane_that_was_conditioned_otherwise_is_refused(bench, tmp_path, first, second, said):
    table = str(tmp_path / "table.csv")
    measure(bench(), rows=1, table=table, **first)
    node = bench().run("next_state", table=table, **{**SMALL, **second})
    assert node.status is (Status.FAILURE if said else Status.SUCCESS)
    assert (said or "") in node.reason


@pytest.mark.parametrize("condition", [True, False])
def test_a_table_that_does_not_say_so_is_held_to_be_conditioned(bench, tmp_path, condition):
    table = tmp_path / "table.csv"
    measure(bench(), rows=1, table=str(table), condition=True)
    head, rest = table.read_text().split("\n", 1)
    kept = json.loads(head.removeprefix("# stretch-characterization/1 "))
    assert kept.pop("conditioned") == {"stretch": 0.01, "depth": 0.002}
    table.write_text(f"# stretch-characterization/1 {json.dumps(kept)}\n{rest}")
    node = bench().run("next_state", table=str(table), condition=condition, **SMALL)
    assert node.status is (Status.SUCCESS if condition else Status.FAILURE)
    assert condition or "held to be conditioned" in node.reason


def test_a_folder_that_is_not_there_is_named(bench, tmp_path):
    node = bench().node("next_state", table=str(tmp_path / "none" / "table.csv"), **SMALL)
    with pytest.raises(InvalidInput, match=r"table\.csv: the table cannot be written .* in a folder that exists"):
        next(iter(node.tick()))


def test_a_row_without_a_table_or_a_contact_is_refused(bench):
    made = bench()
    row = {"geometry": "sphere", "diameter": 0.02, "force": 0.5}
    assert "run 'next_state' with the same 'table' first" in made.run("write_row", **row).reason
    made.run("next_state", **SMALL)
    made.context.hand.contact_height = None
    assert "run 'approach' first" in made.run("write_row", **row).reason


def test_a_replay_begins_as_its_record_did_and_touches_nothing_else(tmp_path):
    table = tmp_path / "table.csv"
    for name, rows in (("one", 3), ("two", None)):
        made = Bench(tmp_path / name)
        made.context.folder.mkdir()
        measure(made, rows=rows, table=str(table))
    before = table.read_bytes()
    again = Bench(tmp_path / "again")
    again.context.folder.mkdir()
    again.context.repeated = tmp_path / "two"
    _, seen = measure(again, table=str(table))
    assert len(seen) == 5
    assert table.read_bytes() == before
    assert table_of(again.context.folder / NAME) == table_of(table)


def test_a_protocol_that_does_not_exist_is_known_before_the_run(bench):
    with pytest.raises(InvalidInput, match="no protocol 'papers'"):
        bench().node("next_state", protocol="papers").prepare()


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ({"stretches": [0.0, 0.2]}, "stretches: 200 mm is past the limits of the hand; use 0 mm to 80 mm"),
        ({"depths": [0.001, 0.029]}, "depths: 29 mm is past the limits of the hand; use 0 mm to 25 mm"),
        ({"diameters": [0.02, 0.1]}, "diameters: no sphere of 100 mm can be mounted; use 5 mm to 80 mm"),
        ({"diameters": [0.0]}, "diameters: no sphere of 0 mm"),
        ({"table": "FOLDER/none/table.csv"}, "there is no folder"),
        ({"table": "FOLDER"}, "it is a folder"),
        ({"table": "FOLDER/notes.csv"}, r"notes\.csv:1: a table begins with"),
        ({"table": "FOLDER/bytes.csv"}, r"bytes\.csv: the table is no text"),
        ({"table": "FOLDER/paper.csv"}, "the table is of protocol 'paper', this run is of 'tasks'"),
    ],
)
def test_what_no_run_can_reach_is_refused_before_it(bench, tmp_path, inputs, said):
    (tmp_path / "notes.csv").write_text("a,b\n1,2\n")
    (tmp_path / "bytes.csv").write_bytes(b"# stretch-characterization/1 \xff\n\n")
    measure(bench(), rows=1, table=str(tmp_path / "paper.csv"), protocol="paper")
    before = {path: path.read_bytes() for path in tmp_path.glob("*.csv")}
    asked = {
        name: value.replace("FOLDER", str(tmp_path)) if isinstance(value, str) else value
        for name, value in inputs.items()
    }
    with pytest.raises(InvalidInput, match=said):
        bench().node("next_state", **{**SMALL, **asked}).prepare()
    assert {path: path.read_bytes() for path in tmp_path.glob("*.csv")} == before


def test_the_limits_are_those_of_the_cell(bench):
    made = bench()
    made.context.limits = Limits(depth="4 mm", stretch=Span(min="5 mm", max="50 mm"))
    for inputs, said in (
        ({"depths": [0.005]}, "depths: 5 mm .* use 0 mm to 4 mm"),
        ({"stretches": [0.06]}, "stretches: 60 mm .* use 5 mm to 50 mm"),
        ({"stretches": [0.0, 0.03]}, "stretches: 0 mm .* use 5 mm to 50 mm"),
    ):
        with pytest.raises(InvalidInput, match=said):
            made.node("next_state", **{**SMALL, "stretches": [0.03], **inputs}).prepare()


@pytest.mark.parametrize("torn", ["", "sphere,20,,0", "sphere,20,,0,2,1,0.5,0.01,60,1"])
def test_a_table_that_can_be_gone_on_with_is_not_refused_before_the_run(bench, tmp_path, torn):
    table = tmp_path / "table.csv"
    bench().node("next_state", table=str(table), **SMALL).prepare()
    assert not table.exists()
    measure(bench(), rows=1, table=str(table))
    with table.open("a") as file:
        file.write(torn)
    whole = table.read_bytes()
    bench().node("next_state", table=str(table), **SMALL).prepare()
    assert table.read_bytes() == whole


def test_the_first_line_is_json(bench, tmp_path):
    measure(bench(), rows=0)
    first = (tmp_path / NAME).read_text().splitlines()[0]
    assert json.loads(first.removeprefix("# stretch-characterization/1 "))["tree"] is None
