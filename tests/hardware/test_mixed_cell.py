"""A real device beside simulated ones: one world, and no reading grows old while a tick is computed."""

import json
import math
import time
from typing import Literal

import numpy as np
import pytest
import typer

import stretch_bt
from stretch_bt.cli.command_calibrate_hand import command as calibrate_hand
from stretch_bt.cli.command_move import command as move
from stretch_bt.clock import MixedClock, RealClock, VirtualClock
from stretch_bt.errors import CellError, DeviceLost, StaleReading, StretchError
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware import cell, implementations
from stretch_bt.hardware.cell import clock_of
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.driver import ArmDriver, DepthCameraDriver, ForceSensorDriver, GripperDriver, Options
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.simulated.camera import SimulatedCamera

GRIPPER = """\
format: stretch-cell/1
devices:
  arm: {type: Arm, use: simulated, height: 120 mm}
  camera: {type: DepthCamera, use: simulated}
  gripper: {type: Gripper, use: of_test}
"""
ARM = GRIPPER.replace("type: Arm, use: simulated, height: 120 mm", "type: Arm, use: of_test").replace(
    "Gripper, use: of_test", "Gripper, use: simulated"
)
TREE = """\
format: stretch-tree/1
devices: {arm: Arm, camera: DepthCamera, gripper: Gripper}
trees:
  main:
    sequence:
      - set_stretch: {stretch: 30 mm, speed: 100 mm/s}
      - wait: {duration: 200 ms}
      - capture: {frame}
"""


class GripperOfTest(GripperDriver):
    """Fingers that go by the machine's clock, at the speed that is asked for."""

    class Options(Options):
        type: Literal["Gripper"]
        use: Literal["of_test"]

    path = (0.0, 0.055, 0.055, 1.0)
    silent = False
    lost = None

    def move(self, opening, speed):
        self.path = (self.cell.now(), self.opening().value, opening, speed)
        return lambda: MotionState.DONE if self.opening().value == opening else MotionState.MOVING

    def stop(self):
        self.path = (0.0, self.opening().value, self.opening().value, 1.0)

    def opening(self):
        if self.lost is not None:
            raise self.lost
        now = self.cell.now()
        start, before, after, speed = self.path
        way = min((now - start) * speed, abs(after - before))
        value = before + (way if after > before else -way)
        value = after if way == abs(after - before) else value
        at = now - 10.0 if self.silent else now
        return Reading(value, at, at, int(now * 1e3))


class ArmOfTest(ArmDriver):
    """An arm that is where it was sent at once."""

    class Options(Options):
        type: Literal["Arm"]
        use: Literal["of_test"]

    at = None

    def follow(self, path, speed):
        self.at = path[-1]
        return lambda: MotionState.DONE

    def pose(self):
        now = self.cell.now()
        return Reading(self.at or Pose((0.0, 0.0, 0.15)), now, now, int(now * 1e3))

    def wrench(self):
        now = self.cell.now()
        return Reading(Wrench((0.0, 0.0, 0.0)), now, now, int(now * 1e3))


class ForceSensorOfTest(ForceSensorDriver):
    """A sensor under another load than the scene's, which begins at zero."""

    class Options(Options):
        type: Literal["ForceSensor"]
        use: Literal["of_test"]

    def wrench(self):
        now = self.cell.now()
        return Reading(Wrench((0.0, 0.0, 4.0 + 1e-3 * math.sin(1e3 * now))), now, now, int(now * 1e3))

    def zero(self):
        """Its zero is the factory's."""


class CameraOfTest(DepthCameraDriver):
    """A camera that sees a wall."""

    class Options(Options):
        type: Literal["DepthCamera"]
        use: Literal["of_test"]

    intrinsics = Intrinsics(60, 60, 32, 24, 64, 48)

    def frame(self):
        now, number = self.cell.now(), int(self.cell.now() * 30)
        picture = np.full((48, 64), 2000, np.uint16)
        return Reading(DepthFrame(picture, 1e-4, self.intrinsics, now, number), now, now, number)


@pytest.fixture
def mixed(tmp_path, monkeypatch):
    own = {
        "Gripper": GripperOfTest,
        "Arm": ArmOfTest,
        "ForceSensor": ForceSensorOfTest,
        "DepthCamera": CameraOfTest,
    }
    for kind, cls in own.items():
        monkeypatch.setitem(implementations.SHIPPED, (kind, "of_test"), f"{__name__}:{cls.__name__}")

    def write(text):
        path = tmp_path / "cell.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    (tmp_path / "tree.yaml").write_text(TREE, encoding="utf-8")
    return write


def test_which_clock_a_cell_goes_by(mixed, tmp_path):
    assert type(clock_of(load_cell("simulated"))) is VirtualClock
    spec = load_cell(mixed(GRIPPER))
    assert type(clock_of(spec)) is MixedClock
    assert type(clock_of(spec, ["gripper", "camera"])) is MixedClock
    assert type(clock_of(spec, ["gripper"])) is RealClock
    assert type(clock_of(spec, ["arm", "camera"])) is VirtualClock
    with pytest.raises(CellError, match="no device 'grip'"):
        clock_of(spec, ["grip"])


PLAYED = """\
format: stretch-cell/1
devices:
  arm: {type: Arm, use: played}
  camera: {type: DepthCamera, use: played}
  gripper: {type: Gripper, use: of_test}
"""


@pytest.mark.parametrize(
    ("command", "given", "clock"),
    [
        (move, {"up": "1mm", "down": None, "speed": "5mm/s", "device": None}, VirtualClock),
        (calibrate_hand, {"seed": 0, "stops": 3, "frames": 1}, MixedClock),
    ],
)
def test_commands_go_by_the_same_clock_as_runs_on_the_devices_that_they_open(mixed, monkeypatch, command, given, clock):
    """Devices that play a recording go by any clock, though nothing is simulated."""
    for kind, cls in (("Arm", ArmOfTest), ("DepthCamera", CameraOfTest)):
        options = type("Options", (cls.Options,), {"__annotations__": {"use": Literal["played"]}})
        played = type(f"Played{kind}", (cls,), {"any_clock": True, "Options": options})
        monkeypatch.setitem(globals(), played.__name__, played)
        monkeypatch.setitem(implementations.SHIPPED, (kind, "played"), f"{__name__}:{played.__name__}")
    clocks = []

    def no(spec, *, clock=None, now=None, **more):
        clocks.append(now.__self__ if clock is None else clock)
        raise DeviceLost("arm", "it is not opened here")

    monkeypatch.setattr(cell, "open_cell", no)
    path = mixed(PLAYED)
    arguments = (str(path),) if command is move else (str(path), path.parent / "hand.yaml")
    with pytest.raises((DeviceLost, typer.Exit)):
        command(*arguments, scene="calibration_sphere", yes=True, json_=False, **given)
    assert [type(found) for found in clocks] == [clock]


def test_the_twin_is_stretched_as_an_own_gripper_says(mixed, tmp_path):
    began = time.perf_counter()
    result = stretch_bt.run(tmp_path / "tree.yaml", cell=mixed(GRIPPER), scene="calibration_sphere")
    assert result.status == "SUCCESS", result.reason
    assert result.keys["frame"].stretch == pytest.approx(0.030, abs=1e-9)
    assert result.task_seconds <= time.perf_counter() - began


def test_no_frame_is_old_however_long_it_takes_to_render(mixed, tmp_path, monkeypatch):
    expose = SimulatedCamera._expose

    def slowly(self, number):
        time.sleep(0.6)  # more than a reading may be old
        return expose(self, number)

    monkeypatch.setattr(SimulatedCamera, "_expose", slowly)
    result = stretch_bt.run(tmp_path / "tree.yaml", cell=mixed(GRIPPER), scene="calibration_sphere")
    assert result.status == "SUCCESS", result.reason


def test_the_twin_presses_as_deep_as_an_own_arm_says(mixed):
    with stretch_bt.open_cell(mixed(ARM), scene="calibration_sphere") as cell:
        assert cell.truth()["depth"] == 0.0
        cell.do("set_stretch", stretch="20 mm", speed="100 mm/s")
        cell.arm.move(cell.arm.pose(1.0).value.at_height(0.057), speed=0.05, owner="by hand")
        assert cell.truth()["depth"] == pytest.approx(0.003, abs=2e-4)
        assert cell.camera.frame(1.0).value.hand_height == pytest.approx(0.057)


def test_a_gripper_that_falls_silent_is_a_fault_of_the_simulation_beside_it(mixed):
    with stretch_bt.open_cell(mixed(GRIPPER), scene="calibration_sphere") as cell:
        cell.gripper.driver.silent = True
        with pytest.raises(
            StaleReading, match="gripper: its latest opening is 10 s old; the simulation beside it needs"
        ):
            cell.camera.frame(1.0)


def test_what_is_simulated_waits_for_a_slow_tick_and_never_outruns_the_machine():
    clock = MixedClock()
    began = clock.machine.now()
    for k in range(8):
        while not clock.reached(k * 0.02):
            clock.wait_until(k * 0.02)
        held = clock.now()
        time.sleep(0.1 if k == 3 else 0.0)  # a tick that takes long
        assert clock.now() == held
        assert clock.now() <= clock.machine.now() - began + 0.02
    assert clock.now() == pytest.approx(0.14)
    assert clock.machine.now() - began > 0.2


def test_times_of_the_machine_are_those_of_the_run():
    clock = MixedClock()
    seen = []
    for k in range(6):
        while not clock.reached(k * 0.02):
            clock.wait_until(k * 0.02)
        seen.append((clock.machine.now(), clock.now()))
        time.sleep(0.03)
    for machine, own in seen:
        assert clock.of_machine(machine) == pytest.approx(own, abs=1e-6)
    times = [clock.of_machine(clock.machine.now() * part / 50) for part in range(51)]
    assert times == sorted(times)
    assert times[-1] <= clock.now()


def test_it_follows_who_ticks_at_times_of_his_own():
    clock = MixedClock()
    clock.follow(0.05)
    before = clock.now()
    time.sleep(0.02)
    clock.follow(0.05)
    assert 0.02 <= clock.now() - before < 0.05
    time.sleep(0.2)
    before = clock.now()
    clock.follow(0.05)
    assert clock.now() - before == pytest.approx(0.05)


ALL = """\
format: stretch-cell/1
devices:
  arm: {type: Arm, use: simulated, height: 120 mm}
  camera: {type: DepthCamera, use: simulated}
  gripper: {type: Gripper, use: simulated}
  force_sensor: {type: ForceSensor, use: simulated}
"""
#: what of the scene a real device leaves unknown
UNKNOWN = {
    "Arm": {"depth"},
    "Gripper": {"stretch"},
    "DepthCamera": {"radius", "stiffness", "deflection", "height", "contact_height"},
    "ForceSensor": {"force", "stiffness"},
}


def with_real(kind):
    return ALL.replace(f"type: {kind}, use: simulated, height: 120 mm", f"type: {kind}, use: of_test").replace(
        f"type: {kind}, use: simulated", f"type: {kind}, use: of_test"
    )


@pytest.mark.parametrize("kind", UNKNOWN)
def test_the_scene_knows_nothing_of_what_a_real_device_measures(mixed, kind):
    with stretch_bt.open_cell(mixed(with_real(kind)), scene="water_balloon") as opened:
        known, world = opened.cell.truth_of_simulated(), opened.cell.truth()
    assert world.keys() - known.keys() == UNKNOWN[kind]
    assert set().union(*UNKNOWN.values()) <= world.keys()


def test_a_force_is_the_arms_where_there_is_no_sensor(mixed):
    cell = with_real("Arm").replace("  force_sensor: {type: ForceSensor, use: simulated}\n", "")
    with stretch_bt.open_cell(mixed(cell), scene="water_balloon") as opened:
        assert "force" not in opened.cell.truth_of_simulated()
        assert "height" in opened.cell.truth_of_simulated()


FORCE = """\
format: stretch-tree/1
devices: {force_sensor: ForceSensor, arm: Arm}
trees: {main: {out: [force], sequence: [measure_force: {count: 3, force}]}}
"""


@pytest.mark.parametrize("real", [False, True])
def test_only_what_a_simulated_sensor_measured_stands_beside_the_truth(mixed, tmp_path, real):
    (tmp_path / "force.yaml").write_text(FORCE)
    cell = mixed(with_real("ForceSensor") if real else ALL)
    result = stretch_bt.run(tmp_path / "force.yaml", cell=cell, scene="water_balloon", out=tmp_path / "record")
    assert result.status == "SUCCESS", result.reason
    assert result.outputs.keys() == {"force"}
    assert result.truth.keys() == (set() if real else {"force"})
    kinds = json.loads((tmp_path / "record" / "run.json").read_text())["simulated"]
    assert ("ForceSensor" in kinds) is not real
    assert "DepthCamera" in kinds


def test_a_fault_of_an_own_gripper_stays_with_the_gripper(mixed):
    """It stayed with the camera that was read, and the gripper was ready."""
    with stretch_bt.open_cell(mixed(GRIPPER), scene="calibration_sphere") as cell:
        lost = cell.gripper.driver.lost = DeviceLost("gripper", "no answer")
        with pytest.raises(DeviceLost, match="no answer"):
            cell.camera.frame(1.0)
        assert (cell.camera.fault, cell.gripper.fault) == (None, lost)
        cell.gripper.driver.lost = None


def test_an_own_gripper_is_not_moved_unasked_to_calibrate_the_hand(mixed, tmp_path, monkeypatch):
    """Beside anything simulated nobody was asked, and its time ran ahead of the fingers."""
    asked = []

    def no(text, **options):
        asked.append(text)
        raise typer.Abort

    monkeypatch.setattr(typer, "confirm", no)
    given = {"scene": "calibration_sphere", "seed": 0, "stops": 3, "frames": 1, "yes": False, "json_": False}
    with pytest.raises(typer.Abort):
        calibrate_hand(str(mixed(GRIPPER)), tmp_path / "hand.yaml", **given)
    assert asked[0].startswith("The fingers will stretch the membrane")


def test_a_subtree_beside_an_own_device_does_not_go_on_after_a_long_pause(mixed, tmp_path):
    with stretch_bt.open_cell(mixed(GRIPPER), scene="calibration_sphere") as cell:
        tree = stretch_bt.subtree(tmp_path / "tree.yaml", cell)
        tree.tick_once()
        tree.tick_once()
        time.sleep(0.4)
        with pytest.raises(StretchError, match="s lie between two ticks"):
            tree.tick_once()
