"""A person who mounts indenters: simulated, and at a terminal."""

import os
import sys

import pytest

from stretch_bt.errors import DeviceFault, DeviceLost, InvalidInput, NotReady
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import DeviceState, MotionState
from stretch_bt.simulation.scene import parse_scene

CONSOLE = "format: stretch-cell/1\ndevices: {operator: {type: Operator, use: console}}\n"


def height(cell):
    return cell.truth()["contact_height"]


def mount(cell, geometry="sphere", size=0.03, owner="a"):
    return cell.devices["operator"].mount(geometry, size, owner=owner)


@pytest.mark.parametrize(
    ("geometry", "size", "top"), [("sphere", 0.030, 0.070), ("cylinder", 0.030, 0.060), ("cone", 0.785, 0.080)]
)
def test_the_indenter_stands_there_once_the_delay_is_over(make_cell, clock, geometry, size, top):
    cell = make_cell()
    before = height(cell)
    motion = mount(cell, geometry, size)
    for clock.time in (0.0, 10.0, 19.9):
        assert motion.poll() is MotionState.MOVING
        assert height(cell) == before
    clock.time = 20.0
    assert motion.poll() is motion.poll() is MotionState.DONE
    assert height(cell) == pytest.approx(top)
    assert cell.truth().get("radius", 0.015) == pytest.approx(0.015)


def test_the_force_is_that_of_the_new_indenter(make_cell, clock):
    cell = make_cell(scene="calibration_cylinder")
    fresh = make_cell(scene="calibration_sphere")
    motion = mount(cell, "sphere", 0.020)
    clock.time = 20.0
    assert motion.poll() is MotionState.DONE
    for each, top in ((cell, 0.060), (fresh, 0.060)):
        each.devices["arm"].move(Pose((0, 0, top - 0.005)), speed=0.1, owner="a")
    clock.time = 25.0
    forces = [each.truth()["force"] for each in (cell, fresh)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)
    assert forces[0] > 0.1


def test_nothing_is_mounted_while_the_hand_touches(make_cell, clock):
    cell = make_cell()
    cell.devices["arm"].move(Pose((0, 0, 0.055)), speed=0.1, owner="a")
    clock.time = 5.0
    with pytest.raises(DeviceFault, match="operator: the hand touches the object; retract it"):
        mount(cell)
    assert cell.devices["operator"].state is DeviceState.FAULT
    assert height(cell) == pytest.approx(0.060)


def test_nothing_is_mounted_where_the_hand_is(make_cell, clock):
    cell = make_cell()
    cell.devices["arm"].move(Pose((0, 0, 0.070)), speed=0.1, owner="a")
    clock.time = 5.0
    with pytest.raises(DeviceFault, match=r"the hand is at 70 mm, where a sphere of 60 mm diameter .* above 102 mm"):
        mount(cell, "sphere", 0.060)


def test_the_hand_that_comes_down_meanwhile_is_in_the_way(make_cell, clock):
    cell = make_cell()
    motion = mount(cell, "sphere", 0.060)
    cell.devices["arm"].move(Pose((0, 0, 0.080)), speed=0.1, owner="a")
    clock.time = 20.0
    with pytest.raises(DeviceFault, match="the hand is at 80 mm"):
        motion.poll()
    assert height(cell) == pytest.approx(0.060)


@pytest.mark.parametrize("end", ["stop", "preempt", "safe stop"])
def test_what_was_called_off_is_not_mounted(make_cell, clock, end):
    cell = make_cell()
    motion = mount(cell, size=0.030)
    clock.time = 10.0
    if end == "stop":
        motion.stop()
    elif end == "preempt":
        mount(cell, size=0.040, owner="b")
    else:
        assert cell.stop() == []
    clock.time = 25.0
    assert motion.poll() is (MotionState.PREEMPTED if end == "preempt" else MotionState.STOPPED)
    assert height(cell) == pytest.approx(0.060)


@pytest.mark.parametrize(
    ("geometry", "size", "said"),
    [
        ("cube", 0.02, "there is no indenter 'cube'; write one of sphere, cylinder, cone"),
        ("sphere", 0.0, "no sphere of 0 mm can be mounted; use 5 mm to 80 mm"),
        ("cylinder", float("nan"), "no cylinder of nan mm"),
        ("cone", 1.6, "no cone of 91.67 deg can be mounted"),
    ],
)
def test_what_does_not_exist_is_not_asked_for(make_cell, notes, geometry, size, said):
    cell = make_cell()
    with pytest.raises(InvalidInput, match=said):
        mount(cell, geometry, size)
    assert notes.lines == []


def test_a_closed_operator_is_not_asked(make_cell):
    cell = make_cell()
    cell.devices["operator"].close()
    with pytest.raises(NotReady):
        mount(cell)


def test_a_shape_that_the_fidelity_lacks_is_refused(clock):
    scene = parse_scene(
        "format: stretch-scene/1\nobject: {type: sphere, diameter: 20 mm, rigid: true}\nfidelity: hertz\neffects: none\n"
    )
    cell = open_cell(load_cell("simulated"), now=clock, scene=scene)
    motion = mount(cell, "cone", 0.785)
    clock.time = 20.0
    with pytest.raises(
        DeviceFault, match="operator: nothing stands in for a cone at hertz fidelity; use fidelity: sheet"
    ):
        motion.poll()
    cell.close()


# --- at a terminal


@pytest.fixture
def terminal(monkeypatch):
    """Stand a terminal in for standard input and return the end at which a person types."""
    typed, read = os.openpty()
    file = os.fdopen(read, "r")
    monkeypatch.setattr(sys, "stdin", file)
    yield typed
    file.close()
    os.close(typed)


@pytest.fixture
def console(tmp_path, clock):
    path = tmp_path / "cell.yaml"
    path.write_text(CONSOLE)
    cells = []

    def make():
        cells.append(open_cell(load_cell(path), now=clock))
        return cells[-1]

    yield make
    for cell in cells:
        cell.close()


def test_enter_answers(terminal, console, capsys):
    cell = console()
    motion = mount(cell, "cone", 0.7853981633974483)
    assert "operator: Mount a cone of 45 degrees" in capsys.readouterr().err
    assert motion.poll() is motion.poll() is MotionState.MOVING
    os.write(terminal, b"\n")
    assert motion.poll() is motion.poll() is MotionState.DONE


def test_what_was_typed_before_does_not_answer(terminal, console):
    cell = console()
    os.write(terminal, b"\n\n")
    motion = mount(cell)
    assert motion.poll() is MotionState.MOVING
    os.write(terminal, b"ready\n")
    assert motion.poll() is MotionState.DONE


def test_a_stop_gives_up_waiting(terminal, console):
    cell = console()
    motion = mount(cell)
    motion.stop()
    os.write(terminal, b"\n")
    assert motion.poll() is MotionState.STOPPED


def test_a_terminal_that_closes_is_a_fault(console, monkeypatch):
    typed, read = os.openpty()
    with os.fdopen(read, "r") as file:
        monkeypatch.setattr(sys, "stdin", file)
        motion = mount(console())
        os.close(typed)
        with pytest.raises(DeviceLost, match="operator: the terminal was closed while the operator was asked"):
            motion.poll()


def test_without_a_terminal_nobody_can_be_asked(console, monkeypatch):
    with open(os.devnull) as nothing:  # noqa: PTH123
        monkeypatch.setattr(sys, "stdin", nothing)
        with pytest.raises(
            DeviceFault, match=r"operator: standard input is no terminal, .*; start the run in a terminal"
        ):
            console()
