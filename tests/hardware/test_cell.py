import math

import pytest

from stretch_bt.clock import VirtualClock
from stretch_bt.errors import CellError, DeviceLost, InvalidInput
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import DeviceState
from stretch_bt.simulation.scene import load_scene


def test_only_the_named_devices_are_opened(make_cell):
    assert list(make_cell(only=["camera", "arm"]).devices) == ["arm", "camera"]


def test_an_unknown_device_is_refused(make_cell):
    with pytest.raises(CellError, match="no device 'camra'; did you mean 'camera'"):
        make_cell(only=["camra"])


def test_a_simulated_cell_needs_a_scene(clock):
    with pytest.raises(InvalidInput, match="needs a scene"):
        open_cell(load_cell("simulated"), now=clock)
    assert load_cell("simulated").simulated


def test_a_recording_needs_none_and_tells_no_truth(make_cell):
    assert make_cell("replay").truth() == {}


def test_truth_is_of_this_instant(make_cell, advance):
    cell = make_cell(scene="water_balloon")
    assert cell.truth()["force"] == 0.0
    advance(cell.devices["arm"].move(Pose((0, 0, 0.05)), speed=0.1, owner="a"))
    truth = cell.truth()
    assert truth["depth"] + truth["deflection"] == pytest.approx(0.01)
    assert truth["force"] / truth["deflection"] == pytest.approx(truth["stiffness"])
    assert all(isinstance(v, float) and math.isfinite(v) for v in truth.values())


def test_a_device_that_does_not_open_closes_the_others(make_cell, tmp_path, monkeypatch):
    from stretch_bt.hardware.simulated.gripper import SimulatedGripper

    opened = []
    from stretch_bt.hardware.simulated.arm import SimulatedArm

    monkeypatch.setattr(SimulatedArm, "open", lambda self: opened.append(self.name))
    monkeypatch.setattr(SimulatedArm, "close", lambda self: opened.remove(self.name))

    def refuse(self):
        assert opened == ["arm"]
        raise DeviceLost(self.name, "no answer")

    monkeypatch.setattr(SimulatedGripper, "open", refuse)
    with pytest.raises(DeviceLost, match="gripper: no answer"):
        make_cell()
    assert opened == []


@pytest.mark.parametrize("error", [DeviceLost("arm", "no answer"), RuntimeError("bug"), OSError("cable")])
@pytest.mark.parametrize("action", ["stop", "close"])
def test_one_device_that_breaks_does_not_keep_the_others(make_cell, monkeypatch, action, error):
    cell = make_cell()
    calls = []
    for name, device in cell.devices.items():
        monkeypatch.setattr(device.driver, "stop", lambda name=name: calls.append(name))

    def fail():
        raise error

    monkeypatch.setattr(cell.devices["camera"].driver, "stop", fail)
    errors = getattr(cell, action)()
    others = ["operator", "force_sensor", "gripper"]
    assert calls == (["arm", *others] if action == "stop" else [*others, "arm"])
    assert len(errors) == 1
    assert "camera" in str(errors[0]) or "arm" in str(errors[0])
    if action == "close":
        assert {d.state for d in cell.devices.values()} == {DeviceState.DISCONNECTED}
        assert cell.close() == []


def test_one_seed_gives_one_history(make_cell, clock):
    def history(seed):
        clock.time = 0.0
        cell = make_cell(seed=seed, scene="water_balloon")
        arm, camera, sensor = (cell.devices[n] for n in ("arm", "camera", "force_sensor"))
        arm.move(Pose((0, 0, 0.05)), speed=0.1, owner="a")
        values = []
        for _ in range(20):
            clock.time += 0.1
            raw = camera.frame(0.1).value.raw
            values.append((raw.tobytes(), sensor.wrench(0.1).value, arm.wrench(0.1).value, arm.pose(0.1).value))
        return values

    assert history(1) == history(1)
    assert history(1) != history(2)


def test_noise_does_not_depend_on_what_was_asked_before(make_cell, clock):
    cell = make_cell()
    clock.time = 0.5
    first = cell.devices["camera"].frame(0.1).value.raw
    clock.time = 0.0
    other = make_cell()
    for _ in range(4):
        clock.time += 0.125
        other.devices["force_sensor"].wrench(0.1)
        raw = other.devices["camera"].frame(0.1).value.raw
    assert (raw == first).all()


def test_the_scene_may_fix_the_seed(tmp_path, clock):
    path = tmp_path / "scene.yaml"
    path.write_text("format: stretch-scene/1\nobject: {type: sphere, diameter: 20 mm, rigid: true}\nseed: 5\n")
    scene = load_scene(path)
    frames = [
        open_cell(load_cell("simulated"), now=clock, seed=seed, scene=scene).devices["camera"].frame(0.1).value.raw
        for seed in (0, 1)
    ]
    assert (frames[0] == frames[1]).all()


def test_a_stop_takes_the_arm_first():
    """Another device may take its time."""
    cell = open_cell(load_cell("simulated"), scene=load_scene("water_balloon"), clock=VirtualClock())
    stopped = []
    for device in cell.devices.values():
        device.stop = lambda device=device: stopped.append(device.name)
    cell.stop()
    assert stopped[0] == "arm"
    assert sorted(stopped) == sorted(cell.devices)
