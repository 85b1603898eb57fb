"""What nodes command, and what they make of what comes back."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from stretch_bt.behaviors.records import Touch
from stretch_bt.errors import DeviceLost
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.runtime.check import check
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.ports import Behavior, Role, Status
from stretch_bt.tree.registry import lookup

MOVING, DONE, BLOCKED, STOPPED = (
    MotionState.MOVING,
    MotionState.DONE,
    MotionState.BLOCKED,
    MotionState.STOPPED,
)
TOUCHED = 0.100
MOVES = ["mount", "press", "retract", "roll", "set_stretch"]
INPUTS = {"depth": 0.005, "stretch": 0.01, "radius": 0.01, "geometry": "sphere", "diameter": 0.02}


@pytest.fixture
def place(scripted_device: Callable[..., Any]) -> Callable[..., tuple[Behavior, Any]]:
    """Place a node on one scripted device: `place("press", {"wrench": ...}, motion=[...], contact=0.1, depth=0.01)`."""

    def make(
        name: str,
        script: dict[str, Any] | None = None,
        motion: Any = (MOVING, DONE),
        contact: Any = None,
        **inputs: Any,
    ) -> tuple[Behavior, Any]:
        info = lookup(name)
        assert info is not None
        port = next(p for p in info.of(Role.DEVICE) if not p.optional)
        device = scripted_device(info.types[port.name].name, script, motion=motion)
        node = info.cls(f"main/{name}")
        node.context = RunContext()
        node.context.devices = {port.name: device}
        given = {"touch": None if contact is None else Touch(contact, 1e-4), **inputs}
        node.device_names = {port.name: port.name}
        for p in info.of(Role.INPUT):
            node.wiring[p.name] = partial(given.get, p.name, p.default)
        return node, device

    return make


def tick(node: Behavior, times: int = 1) -> Status:
    for _ in range(times):
        for _ in node.tick():
            pass
    status: Status = node.status
    return status


def test_press_goes_to_a_depth_counted_from_first_contact(place: Callable[..., Any]) -> None:
    node, arm = place("press", {"pose": Pose((0.01, 0.02, 0.103))}, contact=TOUCHED, depth=0.010, speed=0.004)
    assert tick(node, 2) is Status.SUCCESS
    (command,) = arm.commands
    assert command.arguments["target"].position == pytest.approx((0.01, 0.02, 0.090))
    assert command.arguments["speed"] == 0.004
    assert command.owner == "main/press"


def test_press_stops_at_the_limit_of_force(place: Callable[..., Any]) -> None:
    wrenches = [Wrench((0.0, 0.0, f)) for f in (0.5, 2.0, 2.0, 3.5)]
    node, arm = place("press", {"wrench": wrenches}, motion=[MOVING], contact=TOUCHED, depth=0.010, max_force=2.0)
    assert tick(node, 3) is Status.RUNNING
    assert tick(node) is Status.FAILURE
    assert node.reason == "a force of 3.50 N exceeds the limit of 2 N"
    assert [command.name for command in arm.commands] == ["move", "stop"]


@pytest.mark.parametrize("step", ["press: {depth: 5 mm}", "roll: {depth: 5 mm}", "press_gently: {depth: 5 mm}"])
def test_a_press_without_a_first_contact_is_refused_before_the_run(tmp_path: Path, step: str) -> None:
    head = "format: stretch-tree/1\ndevices: {arm: Arm, camera: DepthCamera, gripper: Gripper}\n"
    (tmp_path / "tree.yaml").write_text(head + f"trees: {{main: {{sequence: [{step}]}}}}\n")
    errors = [d for d in check([tmp_path / "tree.yaml"]) if d.severity == "error"]
    assert any(d.code == "port-missing" and "needs 'touch' (Touch)" in d.message for d in errors)


def test_the_cell_counts_depths_from_the_first_contact_that_is_pressed_from(place: Callable[..., Any]) -> None:
    """Whatever it counted from before: a key may keep the first contact of another object."""
    for name in ("press", "roll"):
        node, _ = place(name, contact=TOUCHED, depth=0.005, radius=0.01)
        node.context.hand.contact_height = 0.3
        tick(node)
        assert node.context.hand.contact_height == TOUCHED


@pytest.mark.parametrize(
    ("contact", "height", "target"),
    [(None, 0.080, 0.100), (TOUCHED, 0.090, 0.120), (TOUCHED, 0.200, 0.200), (TOUCHED, 0.120, 0.120)],
)
def test_retract_never_lowers(place: Callable[..., Any], contact: Any, height: float, target: float) -> None:
    node, arm = place("retract", {"pose": Pose((0.0, 0.0, height))}, contact=contact)
    assert tick(node, 2) is Status.SUCCESS
    assert arm.commands[0].arguments["target"].height == pytest.approx(target)


@pytest.mark.parametrize(("opening", "status"), [(0.0750, "SUCCESS"), (0.0745, "SUCCESS"), (0.0700, "FAILURE")])
def test_set_stretch_believes_the_measured_opening(place: Callable[..., Any], opening: float, status: str) -> None:
    node, gripper = place("set_stretch", {"opening": opening}, stretch=0.020)
    assert tick(node, 2).name == status
    assert gripper.commands[0].arguments["opening"] == pytest.approx(0.055 + 0.020)
    assert status == "SUCCESS" or "15.0 mm instead of 20.0 mm" in node.reason


def test_roll_ends_where_it_began_at_the_depth(place: Callable[..., Any]) -> None:
    node, arm = place("roll", {"pose": Pose((0.05, 0.0, 0.2))}, contact=TOUCHED, radius=0.015, depth=0.005)
    assert tick(node, 2) is Status.SUCCESS
    path = [pose.position for pose in arm.commands[0].arguments["path"]]
    assert path[0] == pytest.approx((0.05, 0.0, 0.095))
    assert path[-1] == pytest.approx(path[0])
    centre = (0.05 - 0.015, 0.0)
    assert [math.dist(p[:2], centre) for p in path] == pytest.approx([0.015] * len(path))


@pytest.mark.parametrize("name", MOVES)
@pytest.mark.parametrize(
    ("end", "reason"), [(BLOCKED, "blocked"), (STOPPED, "stopped"), (MotionState.PREEMPTED, "took")]
)
def test_a_motion_that_ends_early_is_a_failure(
    place: Callable[..., Any], name: str, end: MotionState, reason: str
) -> None:
    node, _ = place(name, motion=[MOVING, end], contact=TOUCHED, **INPUTS)
    assert tick(node) is Status.RUNNING
    assert tick(node) is Status.FAILURE
    assert reason in node.reason


@pytest.mark.parametrize("name", MOVES)
def test_interrupted_it_stops_its_own_motion_and_starts_afresh(place: Callable[..., Any], name: str) -> None:
    node, device = place(name, motion=[MOVING], contact=TOUCHED, **INPUTS)
    tick(node, 3)
    node.stop(Status.INVALID)
    node.stop(Status.INVALID)
    assert [command.name for command in device.commands][1:] == ["stop"]
    assert tick(node) is Status.RUNNING
    assert len(device.commands) == 3


@pytest.mark.parametrize("name", MOVES)
def test_interrupted_it_leaves_the_motion_of_another_owner(place: Callable[..., Any], name: str) -> None:
    node, device = place(name, motion=[MOVING], contact=TOUCHED, **INPUTS)
    tick(node)
    other = device.move(0.08, speed=0.01, owner="main/other")
    node.stop(Status.INVALID)
    assert other.poll() is MOVING
    assert [command.name for command in device.commands].count("stop") == 0


def test_a_fault_while_moving_goes_through_to_the_runner(place: Callable[..., Any]) -> None:
    node, _ = place("retract", motion=[MOVING, DeviceLost("arm", "the connection broke")])
    tick(node)
    with pytest.raises(DeviceLost):
        tick(node)
    node.stop(Status.INVALID)
    assert node.motion is None
