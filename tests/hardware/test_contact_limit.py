"""Where the hand may meet something it is slow: as it is asked to move, as it is measured, and as nodes choose its speed."""

from functools import partial

import pytest

from stretch_bt import run
from stretch_bt.errors import LimitExceeded
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import DeviceState, MotionState
from stretch_bt.hardware.limits import Limits
from stretch_bt.runtime.context import RunContext
from stretch_bt.simulation.scene import load_scene
from stretch_bt.tree.ports import Role
from stretch_bt.tree.registry import lookup

LIMITS = Limits.model_validate({"speed": "200 mm/s", "contact": {"below": "100 mm", "speed": "30 mm/s"}})
CELL = """\
format: stretch-cell/1
devices: {arm: {type: Arm, use: simulated, height: HEIGHT}}
limits: {contact: {below: 100 mm, speed: 30 mm/s}}
"""


@pytest.fixture
def arm(tmp_path, clock, notes):
    """Open an arm that stands at a height."""
    opened = []

    def make(height):
        (tmp_path / "cell.yaml").write_text(CELL.replace("HEIGHT", height))
        scene = load_scene("calibration_sphere")
        opened.append(open_cell(load_cell(tmp_path / "cell.yaml"), now=clock, scene=scene, journal=notes))
        return opened[-1].devices["arm"]

    yield make
    for cell in opened:
        cell.close()


# (where the hand stands, m; where it is sent, m; the highest speed that is taken, mm/s)
WAYS = [
    ("200 mm", [0.15], 250),
    ("200 mm", [0.1], 250),
    ("200 mm", [0.0999], 30),
    ("200 mm", [0.15, 0.0999, 0.2], 30),
    ("90 mm", [0.2], 30),
    ("90 mm", [0.09], 30),
]


@pytest.mark.parametrize(("stands", "way", "most"), WAYS)
def test_a_way_that_may_meet_something_is_slow_all_along(arm, notes, stands, way, most):
    device = arm(stands)
    path = [Pose((0.0, 0.05, height)) for height in way]
    with pytest.raises(
        LimitExceeded, match=f"at most {most} mm/s" + (" below a height of 100 mm, where" if most == 30 else "")
    ):
        device.follow(path, speed=1.01e-3 * most, owner="a")
    assert ("command", "arm", "follow", "a") not in notes.lines
    assert device.state is DeviceState.READY
    assert device.follow(path, speed=1e-3 * most, owner="a").poll() is MotionState.MOVING


@pytest.mark.parametrize(("stands", "to", "faulty"), [("200 mm", 0.12, False), ("95 mm", 0.02, True)])
def test_a_hand_that_is_faster_than_it_may_be_is_stopped(arm, clock, monkeypatch, stands, to, faulty):
    """An arm that goes five times as fast as it was asked to."""
    device = arm(stands)
    follow = device.driver.follow
    monkeypatch.setattr(device.driver, "follow", lambda path, speed: follow(path, 5 * speed))
    motion = device.move(Pose((0.0, 0.05, to)), speed=0.03, owner="a")

    def go_on():
        while motion.poll() is MotionState.MOVING:
            clock.time += 0.05

    if not faulty:
        go_on()
        return
    with pytest.raises(
        LimitExceeded,
        match=r"measured speed [\d.]+ mm/s is past the limit of the cell, at most 30 mm/s below a height of 100 mm",
    ):
        go_on()
    assert device.state is DeviceState.FAULT
    height = device.pose(1.0).value.height
    clock.time += 1.0
    assert device.pose(1.0).value.height > height - 0.15**2 / (2 * 0.5) - 1e-4
    assert height > 0.08


def test_a_limit_that_is_higher_than_that_of_the_arm_changes_nothing():
    limits = LIMITS.model_copy(update={"speed": 0.02})
    assert limits.span("contact_speed")[1] == limits.slowed(0.02, [0.05]) == 0.02
    limits.check_way("arm", 0.02, [0.05])
    with pytest.raises(LimitExceeded, match=r"at most 20 mm/s$"):
        limits.check_way("arm", 0.021, [0.05])


# (node, inputs, height of the hand, speed that it asks for, speed that it has where the cell has a limit for contact)
TRAVELS = [
    ("retract", {"clearance": 0.02, "speed": 0.05}, 0.09, 0.05, 0.03),
    ("retract", {"clearance": 0.02, "speed": 0.05}, 0.11, 0.05, 0.05),
    ("retract", {"clearance": 0.02, "speed": 0.01}, 0.09, 0.01, 0.01),
    ("move_over", {"x": 0.01, "y": 0.0}, 0.09, 0.1, 0.03),
    ("move_over", {"x": 0.01, "y": 0.0}, 0.1, 0.1, 0.1),
]


@pytest.mark.parametrize("limits", [None, LIMITS], ids=["without", "with"])
@pytest.mark.parametrize(("name", "inputs", "height", "asked", "slow"), TRAVELS)
def test_nodes_that_travel_go_no_faster_than_the_cell_allows(
    scripted_device, limits, name, inputs, height, asked, slow
):
    info = lookup(name)
    node = info.cls(f"main/{name}")
    node.context = RunContext()
    node.context.limits = limits
    device = scripted_device("Arm", {"pose": Pose((0.0, 0.0, height))})
    node.context.devices, node.device_names = {"arm": device}, {"arm": "arm"}
    for port in info.of(Role.INPUT):
        node.wiring[port.name] = partial(inputs.get, port.name, port.default)
    list(node.tick())
    [command] = device.commands
    assert command.arguments["speed"] == (asked if limits is None else slow)


def test_a_run_goes_slowly_where_its_cell_says_so(tmp_path):
    (tmp_path / "cell.yaml").write_text(CELL.replace("HEIGHT", "90 mm"))
    (tmp_path / "tree.yaml").write_text(
        "format: stretch-tree/1\ndevices: {arm: Arm}\ntrees: {main: {sequence: [move_over: {x: 60 mm, y: 0 mm}]}}\n"
    )
    slow = run(tmp_path / "tree.yaml", cell=tmp_path / "cell.yaml", scene="calibration_sphere", out=tmp_path / "slow")
    fast = run(tmp_path / "tree.yaml", cell="simulated", scene="calibration_sphere", out=tmp_path / "fast")
    assert (slow.status, fast.status) == ("SUCCESS", "SUCCESS")
    assert slow.task_seconds > 0.06 / 0.03 > fast.task_seconds
