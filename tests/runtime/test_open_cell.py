"""An open cell: nodes and subtrees one call at a time."""

import json
import os
import signal
import time

import numpy as np
import pytest

import stretch_bt
from stretch_bt.errors import DeviceFault, InvalidInput, LimitExceeded, NodeError, Refused
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.runtime.one_call import called, names
from stretch_bt.runtime.report import write_report
from stretch_bt.tree import registry
from stretch_bt.units import Estimate

TREE = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
trees:
  main:
    out: {h0: Length, radius: Length}
    sequence:
      - set_stretch: {stretch: 30 mm}
      - approach: {contact_height: $h0}
      - press: {depth: 7 mm}
      - average_frames: {frame}
      - segment_contact: {frame}
      - fit_sphere: {sphere}
      - set: {radius: sphere.radius}
"""


@pytest.fixture
def tree(tmp_path):
    path = tmp_path / "task.yaml"
    path.write_text(TREE, encoding="utf-8")
    return path


def script(opened):
    """Do from Python what TREE does."""
    opened.do("set_stretch", stretch=0.030)
    top = opened.do("approach")
    opened.do("press", depth="7 mm")
    opened.do("average_frames")
    opened.do("segment_contact")
    return top.contact_height, opened.do("fit_sphere").sphere


def stands(opened):
    before = opened.arm.pose(1.0).value
    opened.clock.advance(0.5)
    return opened.arm.pose(1.0).value.height - before.height < 0.002  # it brakes


def motions(commands):
    return [(c.time, c.device, c.name, c.arguments) for c in commands]


def test_calls_give_what_the_same_task_in_yaml_gives(opened, tree):
    result = stretch_bt.run(tree, scene="calibration_sphere")
    top, sphere = script(opened)
    assert (top, top.sd) == (result.keys["h0"], result.keys["h0"].sd)
    assert (sphere.radius, sphere.radius_sd) == (result.keys["sphere"].radius, result.keys["sphere"].radius_sd)
    assert motions(opened.commands) == motions(result.commands)
    assert (opened.ticks, opened.clock.now()) == (result.ticks, result.task_seconds)


def test_ticks_of_calls_count_on_in_the_record(tmp_path):
    with stretch_bt.open_cell(scene="calibration_sphere", out=tmp_path / "record") as opened:
        for _ in range(3):
            opened.do("wait", duration="100 ms")  # three ticks, of which the last is the first of what follows
        assert opened.ticks == 7
        opened.clock.advance(1.0)
        opened.do("wait", duration="100 ms")
        assert (opened.ticks, opened.clock.now()) == (10, pytest.approx(1.4))
    events = [json.loads(line) for line in (tmp_path / "record" / "events.jsonl").read_text().splitlines()]
    ends = [(e["tick"], e["time"]) for e in events if e.get("path") == "do/wait" and e["status"] == "SUCCESS"]
    assert ends == [(3, 0.1), (5, 0.2), (7, pytest.approx(0.3)), (10, pytest.approx(1.4))]


def test_a_record_that_is_left_out_is_the_latest_and_a_failure_unsets_its_own(opened):
    opened.do("set_stretch", stretch="30 mm")
    opened.do("approach", speed="20 mm/s")
    assert "touch" in opened.records
    opened.do("retract", clearance="20 mm")
    opened.do("capture")
    with pytest.raises(Refused) as refused:
        opened.do("segment_contact")
    assert "contact" not in opened.records
    assert refused.value.reason.startswith("segment_contact: ")
    assert refused.value.path == "segment_contact"
    with pytest.raises(
        InvalidInput, match=r"fit_sphere needs contact \(a Contact: call segment_contact before, or give"
    ):
        opened.do("fit_sphere")


@pytest.mark.parametrize(
    ("name", "ports", "said"),
    [
        ("pres", {}, "there is no node and no subtree 'pres'; did you mean 'press'?"),
        ("press", {"dept": 1.0}, "press has no port 'dept'; did you mean 'depth'?"),
        ("press", {"depth": "5 kg", "touch": "record"}, "press: touch takes Touch, not 'record'"),
        ("set_stretch", {"stretch": "5 kg"}, "set_stretch.stretch takes Length, but '5 kg' is Mass"),
        ("set_stretch", {"stretch": 5.0}, "set_stretch.stretch: 5000 mm is outside 0 mm to 80 mm"),
        (
            "set_stretch",
            {"stretch": float("nan")},
            "set_stretch: stretch takes Length, a number in m or text with a unit",
        ),
        ("set_stretch", {"stretch": object}, "set_stretch: stretch takes Length, a number in m or text with a unit"),
        ("set_stretch", {}, "set_stretch needs stretch"),
        (
            "set_stretch",
            {"stretch": 0.01, "timeout": "soon"},
            "set_stretch: timeout takes a time above 0, as in '10 s', not 'soon'",
        ),
        ("capture", {"frame": 1}, "capture gives 'frame': read it from what the call returns"),
        ("retract", {"arm": "left"}, "left"),
        ("lib/palpation.feel", {}, "has no tree 'feel'"),
        ("lib/nothing.feel", {}, "there is no file 'lib/nothing.yaml' here, nor among the shipped trees"),
    ],
)
def test_a_call_that_is_wrong_says_what_and_moves_nothing(opened, name, ports, said):
    with pytest.raises(InvalidInput) as wrong:
        opened.do(name, **ports)
    assert said in str(wrong.value)
    assert ".yaml:" not in str(wrong.value)
    assert opened.commands == []


@pytest.mark.parametrize(
    "value", [0.012, np.float64(0.012), np.float32(0.012), "12 mm", "0.012 m", Estimate(0.012, 1e-4)]
)
def test_numbers_are_si_and_text_has_units(opened, value):
    opened.do("set_stretch", stretch=value)
    assert opened.gripper.opening(1.0).value - 0.055 == pytest.approx(0.012, abs=1e-8)


def test_timeout_and_guard_are_as_in_a_tree_file(opened):
    with pytest.raises(Refused, match="out of time while retract was running"):
        opened.do("retract", clearance=0.1, timeout=0.2)
    assert stands(opened)
    with pytest.raises(Refused, match=r"'arm.height < 50 mm' does not hold"):
        opened.do("retract", clearance=0.05, guard="arm.height < 50 mm")


def test_a_call_that_ends_well_stops_only_its_own_motion_and_any_other_end_all(opened):
    motion = opened.gripper.move(0.08, speed=0.001, owner="by hand")
    opened.do("retract", clearance=0.005)
    assert motion.poll() is MotionState.MOVING
    with pytest.raises(Refused):
        opened.do("retract", clearance=0.1, timeout="100 ms")
    assert motion.poll() is MotionState.STOPPED


def test_an_error_of_a_node_and_a_fault_of_a_device_come_as_they_are(opened, monkeypatch):
    class BreaksForTest(stretch_bt.Behavior):
        """Break."""

        def update(self):
            raise ZeroDivisionError

    monkeypatch.setattr(registry, "_nodes", {**registry.load_all()})
    stretch_bt.node(BreaksForTest)
    with pytest.raises(NodeError, match="ZeroDivisionError"):
        opened.do("breaks_for_test")
    fault = DeviceFault("camera", "no light")
    monkeypatch.setattr(opened.camera.driver, "frame", lambda: (_ for _ in ()).throw(fault))
    with pytest.raises(DeviceFault, match="no light"):
        opened.do("capture")


@pytest.mark.parametrize(
    ("raised", "kind", "said"),
    [
        (ValueError("oh"), NodeError, r"retract: prepare\(\) broke \(ValueError: oh\)"),
        (InvalidInput("too high; give less"), InvalidInput, "retract: too high; give less"),
    ],
)
def test_what_a_node_says_before_its_first_tick_names_it(opened, monkeypatch, raised, kind, said):
    def prepare(self):
        raise raised

    monkeypatch.setattr(registry.load_all()["retract"].cls, "prepare", prepare)
    with pytest.raises(kind, match=said):
        opened.do("retract")


def test_a_signal_in_a_call_stops_all_and_is_an_interrupt(opened):
    opened.clock.reached = lambda deadline: (opened.clock.now() > 0.3 and os.kill(os.getpid(), signal.SIGINT)) or True
    with pytest.raises(KeyboardInterrupt):
        opened.do("retract", clearance=0.1)
    del opened.clock.reached
    assert stands(opened)
    opened.do("retract", clearance=0.001)


def test_a_signal_between_two_calls_stops_what_still_moves(opened):
    motion = opened.arm.move(opened.arm.pose(1.0).value.moved(z=0.05), speed=0.01, owner="by hand")

    def wait():
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(1.0)

    with pytest.raises(KeyboardInterrupt):
        wait()
    assert motion.poll() is MotionState.STOPPED


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("first", [0, 1])
def test_the_handlers_of_signals_come_back_in_whatever_order_cells_close(number, first):
    before = signal.getsignal(number)
    cells = [stretch_bt.open_cell(scene="calibration_sphere") for _ in range(2)]
    assert before in (signal.SIG_IGN, signal.getsignal(number)) or signal.getsignal(number) != before
    cells[first].close()
    cells[1 - first].close()
    assert signal.getsignal(number) == before


def test_a_handler_that_somebody_else_set_is_taken_again_at_the_next_use(opened):
    signal.signal(signal.SIGINT, signal.default_int_handler)  # as a notebook does before each of its cells
    motion = opened.gripper.move(0.08, speed=0.001, owner="by hand")
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    assert motion.poll() is MotionState.STOPPED


def test_a_library_that_was_edited_is_read_again(opened, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for stretch in ("30 mm", "10 mm"):
        body = f"trees: {{go: {{sequence: [set_stretch: {{stretch: {stretch}}}]}}}}\n"
        (tmp_path / "own.yaml").write_text(f"format: stretch-tree/1\ndevices: {{gripper: Gripper}}\n{body}")
        opened.do("own.yaml.go")
        assert opened.gripper.opening(1.0).value - 0.055 == pytest.approx(float(stretch.split()[0]) * 1e-3)


def test_what_does_not_open_is_closed_again(monkeypatch):
    from stretch_bt.hardware.simulated.camera import SimulatedCamera

    opened = []
    monkeypatch.setattr(SimulatedCamera, "open", lambda self: (_ for _ in ()).throw(DeviceFault("camera", "no light")))
    monkeypatch.setattr(SimulatedCamera, "close", lambda self: opened.append(self))
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(DeviceFault, match="no light"):
        stretch_bt.open_cell(scene="calibration_sphere")
    assert len(opened) == 1
    assert signal.getsignal(signal.SIGINT) == before


def test_it_closes_by_with_or_by_close_and_says_so_afterwards():
    before = signal.getsignal(signal.SIGINT)
    opened = stretch_bt.open_cell(scene="calibration_sphere", only=["gripper"])
    assert list(opened.devices) == ["gripper"]
    with pytest.raises(InvalidInput, match="capture needs a device of kind DepthCamera, and this cell has none open"):
        opened.do("capture")
    opened.close()
    opened.close()
    assert repr(opened) == "<a closed cell>"
    for use in (
        lambda: opened.devices,
        lambda: opened.do("wait", duration=1),
        lambda: stretch_bt.run("x.yaml", cell=opened),
    ):
        with pytest.raises(InvalidInput, match="this cell is closed; open it again"):
            use()
    with pytest.raises(AttributeError, match="has no 'arm'; its devices: none while it is closed"):
        _ = opened.arm
    assert signal.getsignal(signal.SIGINT) is before, "what is closed hears no signal"


def test_a_simulated_cell_without_a_scene_says_what_to_write():
    with pytest.raises(InvalidInput, match="scene='water_balloon'"):
        stretch_bt.open_cell()


def test_what_can_be_called_completes_with_its_ports(opened):
    assert {"press", "approach", "fit_sphere"} <= set(dir(opened.do))
    assert {"arm", "do", "clock"} <= set(dir(opened))
    import inspect

    assert {"depth", "touch", "timeout", "guard"} <= set(inspect.signature(opened.do.press).parameters)
    assert opened.do.press.__doc__.startswith(called("press").doc)
    assert "    depth: Length\n" in opened.do.press.__doc__
    assert inspect.signature(opened.do.press).parameters["depth"].default is inspect.Parameter.empty
    assert opened.do.wait(duration="50 ms") == {}
    with pytest.raises(AttributeError, match="did you mean 'press'"):
        _ = opened.do.pres


def test_everything_that_can_be_called_tells_its_ports():
    for name in names():
        found = called(name)
        assert found.doc
        assert found.required <= found.ports.keys()


def test_texts_are_short(opened):
    script(opened)
    frame = opened.do("capture")
    assert len(repr(frame)) < 200
    assert len(repr(opened)) < 200
    with pytest.raises(AttributeError, match="capture gives no 'frme'; did you mean 'frame'"):
        _ = frame.frme


def test_a_record_of_calls_holds_what_they_did(tmp_path):
    with stretch_bt.open_cell(scene="calibration_sphere", out=tmp_path / "record") as opened:
        opened.do("set_stretch", stretch=0.01)
        with pytest.raises(Refused):
            opened.do("retract", clearance=0.1, timeout=0.1)
    ended = json.loads((tmp_path / "record" / "result.json").read_text())
    assert (ended["ticks"], ended["task_seconds"]) == (opened.ticks, opened.clock.now())
    assert "calls from Python" in write_report(tmp_path / "record").read_text("utf-8")
    events = [json.loads(line) for line in (tmp_path / "record" / "events.jsonl").read_text().splitlines()]
    statuses = [(e["path"], e["status"]) for e in events if e.get("type") == "status"]
    assert ("do/set_stretch", "SUCCESS") in statuses
    assert next(e["device"] for e in events if e.get("type") == "command") == "gripper"
    ticks = [e["tick"] for e in events if "tick" in e]
    assert ticks == sorted(ticks)


def test_limit_errors_of_own_commands_are_refused_too(opened):
    with pytest.raises(LimitExceeded):
        opened.arm.move(opened.arm.pose(1.0).value.moved(z=5.0), speed=0.01, owner="by hand")
