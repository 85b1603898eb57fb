"""A whole task on devices that its caller gave: one cell, one clock, one set of limits, and what was left undone comes first."""

import pytest

import stretch_bt
from stretch_bt.errors import InvalidInput, Refused
from stretch_bt.runtime.replay import replay

TREE = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
trees:
  main:
    out: {h0: Length}
    sequence:
      - set_stretch: {stretch: 30 mm}
      - approach: {contact_height: $h0}
"""


@pytest.fixture
def opened(at_hertz, hand_at, tmp_path):
    """An open cell whose hand is near a simulated sphere."""
    with stretch_bt.open_cell(hand_at(66), scene=at_hertz("calibration_sphere", tmp_path)) as cell:
        yield cell


@pytest.fixture
def tree(tmp_path):
    path = tmp_path / "task.yaml"
    path.write_text(TREE, encoding="utf-8")
    return path


def test_a_run_on_an_open_cell_takes_all_of_it(opened, tree):
    opened.do("set_stretch", stretch=0.02)
    before = opened.clock.now()
    result = stretch_bt.run(tree, cell=opened)
    assert result.status == "SUCCESS"
    assert result.truth["h0"]["value"] == pytest.approx(60.0, abs=0.1)
    assert opened.clock.now() == pytest.approx(before + result.task_seconds, abs=0.051)
    assert {c.device for c in result.commands} == {"arm", "gripper"}
    assert result.readings
    assert opened.hand.contact_height == pytest.approx(0.06, abs=1e-3)
    assert stretch_bt.run(tree, cell=opened).status == "FAILURE"  # the hand is where the first left it


def test_its_record_replays(opened, tree):
    result = stretch_bt.run(tree, cell=opened)
    assert replay(result.record).same


PRESS = "trees: {main: {sequence: [approach: {}, press: {depth: 6 mm}]}}"
LIMITED = """\
format: stretch-cell/1
devices:
  arm: {type: Arm, use: simulated, height: 66 mm}
  gripper: {type: Gripper, use: simulated}
  camera: {type: DepthCamera, use: simulated}
limits: {depth: 5 mm}
"""


@pytest.mark.parametrize("way", ["cell", "open", "devices", "subtree", "do"])
def test_limits_hold_whichever_way_a_tree_comes_to_its_devices(at_hertz, tmp_path, way):
    scene = at_hertz("calibration_sphere", tmp_path)
    (tmp_path / "cell.yaml").write_text(LIMITED, encoding="utf-8")
    path = tmp_path / "press.yaml"
    path.write_text("format: stretch-tree/1\ndevices: {arm: Arm, gripper: Gripper, camera: DepthCamera}\n" + PRESS)
    if way == "cell":
        reason = stretch_bt.run(path, cell=tmp_path / "cell.yaml", scene=scene).reason
    else:
        with stretch_bt.open_cell(tmp_path / "cell.yaml", scene=scene) as opened:
            reason = REASONS[way](opened, path)
    assert "6 mm" in reason
    assert "5 mm" in reason


def by_subtree(opened, path):
    tree = stretch_bt.subtree(path, opened)
    for _ in range(2000):
        tree.tick_once()
        if tree.status.name != "RUNNING":
            return tree.feedback_message
    raise AssertionError


def by_do(opened, path):
    opened.do("approach")
    with pytest.raises(Refused) as refused:
        opened.do("press", depth=0.006)
    return refused.value.reason


REASONS = {
    "open": lambda opened, path: stretch_bt.run(path, cell=opened).reason,
    "devices": lambda opened, path: stretch_bt.run(path, devices=opened.devices).reason,
    "subtree": by_subtree,
    "do": by_do,
}


def test_two_clocks_or_none_are_refused(opened, tree):
    with stretch_bt.open_cell(scene="calibration_sphere") as other:
        mixed = {**opened.devices, "arm": other.arm}
        with pytest.raises(InvalidInput, match="of more than one cell"):
            stretch_bt.run(tree, devices=mixed)

    class OwnCamera:
        clock = None

    with pytest.raises(InvalidInput, match=r"'camera' \(OwnCamera\) has no clock that a run can go by"):
        stretch_bt.run(tree, devices={**opened.devices, "camera": OwnCamera()})
    own = OwnCamera()
    own.clock = stretch_bt.clock.RealClock()
    with pytest.raises(InvalidInput, match="go by 2 clocks"):
        stretch_bt.run(tree, devices={**opened.devices, "camera": own})


def test_one_device_has_one_name(opened, tmp_path):
    path = tmp_path / "two.yaml"
    path.write_text(
        "format: stretch-tree/1\ndevices: {one: Gripper, two: Gripper}\n"
        "trees: {main: {sequence: [set_stretch: {stretch: 5 mm, gripper: one}, set_stretch: {stretch: 6 mm, gripper: two}]}}\n"
    )
    before = opened.gripper.opening(1.0).value
    with pytest.raises(InvalidInput, match="'one' and 'two' are one device"):
        stretch_bt.run(path, devices={"one": opened.gripper, "two": opened.gripper}, out=tmp_path / "record")
    assert opened.gripper.opening(1.0).value == before
    assert not (tmp_path / "record").exists()


@pytest.mark.parametrize("more", [{"scene": "water_balloon"}, {"devices": {}}])
def test_an_open_cell_has_its_own_scene_and_devices(opened, tree, more):
    with pytest.raises(InvalidInput, match="open cell"):
        stretch_bt.run(tree, cell=opened, **more)


def test_virtual_time_ends(tmp_path):
    path = tmp_path / "forever.yaml"
    path.write_text("format: stretch-tree/1\ntrees: {main: {repeat: {times: 1000000, do: [wait: {duration: 1 s}]}}}\n")
    result = stretch_bt.run(path, longest=60.0, out=tmp_path / "record")
    assert (result.status, result.task_seconds) == ("FAILURE", pytest.approx(60.0, abs=0.1))
    assert (
        "no end within 1 min of virtual time; end it with a 'timeout', or let it take longer (`--longest`)"
        in result.reason
    )
    assert replay(tmp_path / "record").same


# --- devices of an open cell, given one by one

RAISED = """\
format: stretch-tree/1
devices: {left: Arm}
params: {height: {type: Length, default: 5 mm}}
trees:
  main:
    out: {height_before: Length}
    sequence:
      - set: {height_before: left.height}
      - retract: {clearance: $height, arm: left}
"""
OWING = """\
format: stretch-tree/1
devices: {arm: Arm}
trees: {main: {sequence: [wait: {duration: 1 s}], finally: [retract: {clearance: 20 mm}]}}
"""
ASKING = """\
format: stretch-scene/1
object: {type: box, length: 40 mm, width: 40 mm, height: 40 mm, rigid: true}
params: {height: 9 mm}
"""


@pytest.fixture
def raised(tmp_path):
    path = tmp_path / "raised.yaml"
    path.write_text(RAISED, encoding="utf-8")
    return path


@pytest.mark.parametrize("way", ["run", "tick_task"])
def test_what_the_cell_owes_is_done_before_a_task_on_its_devices(opened, tmp_path, raised, tick_task, way):
    (tmp_path / "owing.yaml").write_text(OWING, encoding="utf-8")
    before = opened.arm.pose(1.0).value.height
    owing = stretch_bt.subtree(tmp_path / "owing.yaml", opened)
    owing.tick_once()
    owing.stop(owing.status.INVALID)
    assert opened.pending_finally
    if way == "run":
        begins_at = stretch_bt.run(raised, devices={"left": opened.arm}).outputs["height_before"]["value"] * 1e-3
    else:
        task = tick_task(raised, devices={"left": opened.arm})
        task.tick()
        begins_at = task.keys["height_before"]
    assert not opened.pending_finally
    assert begins_at == pytest.approx(before + 0.020, abs=1e-4)


@pytest.mark.parametrize("way", ["run", "tick_task"])
def test_a_task_on_devices_begins_with_the_params_of_their_scene(tmp_path, raised, tick_task, way):
    (tmp_path / "scene.yaml").write_text(ASKING, encoding="utf-8")
    with stretch_bt.open_cell(scene=tmp_path / "scene.yaml") as opened:
        before = opened.arm.pose(1.0).value.height
        if way == "run":
            result = stretch_bt.run(raised, devices={"left": opened.arm}, out=tmp_path / "record")
            [command] = result.commands
        else:
            task = tick_task(raised, devices={"left": opened.arm})
            task.tick()
            [command] = task.commands("left")
        assert command.arguments["target"].height == pytest.approx(before + 0.009, abs=1e-6)


def test_a_task_on_devices_knows_the_truth_of_their_scene_and_is_ticked_again(opened, tree, tmp_path):
    result = stretch_bt.run(tree, devices=dict(opened.devices), out=tmp_path / "record")
    assert result.truth["h0"]["value"] == pytest.approx(60.0, abs=0.1)
    assert replay(tmp_path / "record").identical


def test_a_safe_stop_stops_the_arm_first(opened, monkeypatch):
    order = []
    for name, device in opened.devices.items():
        stop = device.stop
        monkeypatch.setattr(device, "stop", lambda name=name, stop=stop: (order.append(name), stop())[1])
    lent = opened.lend({name: opened.devices[name] for name in sorted(opened.devices, key=lambda name: name == "arm")})
    assert lent.stop() == []
    assert order[0] == "arm"
    assert len(order) == len(opened.devices)
