import math
from contextlib import nullcontext

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.simulation.scene import load_scene


def test_the_table_is_never_entered(clock, advance, tmp_path):
    path = tmp_path / "cell.yaml"
    path.write_text(
        "format: stretch-cell/1\ndevices: {arm: {type: Arm, use: simulated, x: 200 mm}}\n"
        "limits: {height: {min: -100 mm, max: 500 mm}}\n"
    )
    arm = open_cell(load_cell(path), now=clock, scene=load_scene("water_balloon")).devices["arm"]
    motion = arm.move(Pose((0.2, 0, -0.05)), speed=0.2, owner="a")
    assert advance(motion) is MotionState.BLOCKED
    assert arm.pose(1.0).value.height == 0.0


@pytest.mark.parametrize(
    ("x", "told"), [("0 mm", "reaches 60 mm above the table, and the hand begins at 29"), ("200 mm", None)]
)
def test_a_hand_does_not_begin_inside_the_object(clock, tmp_path, x, told):
    """A cylinder taller than the hand stands was pressed for minutes, and then had no equilibrium."""
    path = tmp_path / "cell.yaml"
    arm = f"{{type: Arm, use: simulated, x: {x}, height: 29 mm}}"
    path.write_text(f"format: stretch-cell/1\ndevices: {{arm: {arm}}}\n")
    with nullcontext() if told is None else pytest.raises(InvalidInput, match=told):
        open_cell(load_cell(path), now=clock, scene=load_scene("water_balloon")).close()


def test_the_fingers_end(clock, advance, tmp_path):
    path = tmp_path / "cell.yaml"
    path.write_text("format: stretch-cell/1\ndevices: {g: {type: Gripper, use: simulated, max_opening: 100 mm}}\n")
    gripper = open_cell(load_cell(path), now=clock, scene=load_scene("water_balloon")).devices["g"]
    assert advance(gripper.move(0.12, speed=0.1, owner="a")) is MotionState.BLOCKED
    assert gripper.opening(1.0).value == 0.1
    assert advance(gripper.move(0.06, speed=0.1, owner="a")) is MotionState.DONE


def test_a_frame_shows_the_hand_as_it_was_at_exposure(make_cell, clock):
    """A frame belongs to its own instant also when the arm got another command since."""
    cell = make_cell()
    arm, camera = cell.devices["arm"], cell.devices["camera"]
    arm.move(Pose((0, 0, 0.1)), speed=0.1, owner="a")
    clock.time = 0.5
    here = arm.pose(1.0).value.height
    clock.time = 0.51
    arm.move(Pose((0, 0, 0.2)), speed=0.1, owner="b")
    clock.time = 0.52
    frame = camera.frame(0.1)
    assert frame.host_time == frame.value.time == 0.5
    assert frame.value.hand_height == pytest.approx(here)
    assert camera.frame(0.1) is frame
    table = np.percentile(frame.value.depth, 99)
    assert table == pytest.approx(0.2 + here, abs=1e-3)


BALL = "format: stretch-scene/1\nobject: {type: sphere, diameter: 20 mm, rigid: true, base: 40 mm}\nfidelity: hertz\n"


def ball(tmp_path, effects):
    path = tmp_path / "ball.yaml"
    path.write_text(f"{BALL}effects: {effects}\n")
    return path


def test_a_press_is_seen_and_felt(make_cell, clock, advance, tmp_path):
    cell = make_cell(scene=ball(tmp_path, "{force_sensor_noise: on}"))
    arm, gripper, camera, sensor = (cell.devices[n] for n in ("arm", "gripper", "camera", "force_sensor"))
    advance(gripper.move(0.085, speed=0.1, owner="a"))
    advance(arm.move(Pose((0, 0, 0.05)), speed=0.1, owner="a"))
    clock.time += 0.1
    frame = camera.frame(0.1).value
    assert frame.stretch == pytest.approx(0.03)
    intrinsics = camera.intrinsics
    top = frame.depth[int(intrinsics.cy) - 3 : int(intrinsics.cy) + 4, int(intrinsics.cx) - 3 : int(intrinsics.cx) + 4]
    assert frame.plane_distance - top.mean() == pytest.approx(0.010, abs=3e-4)
    forces = []
    for _ in range(200):
        clock.time += 0.001
        forces.append(sensor.wrench(0.1).value.force)
    truth = cell.truth()
    assert np.mean(forces, axis=0) == pytest.approx((0, 0, truth["force"]), abs=4 * 0.02 / math.sqrt(200))
    assert np.std(forces, axis=0) == pytest.approx(0.02, rel=0.25)
    sensor.zero()
    assert abs(sensor.wrench(0.1).value.force[2]) < 0.1


def test_repeatability_is_what_the_scene_says(clock, advance, tmp_path):
    scene = load_scene(ball(tmp_path, "{repeatability: {sd: 0.05 mm}}"))
    cell = open_cell(load_cell("simulated"), now=clock, scene=scene)
    arm, errors = cell.devices["arm"], []
    for k in range(200):
        advance(arm.move(Pose((0, 0, 0.052 if k % 2 else 0.05)), speed=0.25, owner="a"))
        told = arm.pose(1.0).value.height
        errors.append(cell.truth()["contact_height"] - cell.truth()["depth"] - told)
    assert np.std(errors) == pytest.approx(5e-5, rel=0.2)
    assert abs(np.mean(errors)) < 1.5e-5


def test_what_is_told_is_as_old_as_the_scene_says(clock, tmp_path):
    """While the hand goes down, a late force is the force where the hand was, and a late frame shows it there."""
    late = load_scene(
        ball(tmp_path, "{latency: {camera: 100 ms, force: 40 ms}, force_sensor_noise: off, fixed_pattern: off}")
    )
    cell = open_cell(load_cell("simulated"), now=clock, scene=late)
    twin = cell._context.twin
    cell.devices["arm"].move(Pose((0, 0, 0.05)), speed=0.05, owner="a")
    clock.time = 1.4
    felt = cell.devices["force_sensor"].wrench(0.1).value.force[2]
    assert felt == pytest.approx(twin.contact(1.36).force[2])
    assert 0 < felt < twin.contact(1.4).force[2]
    frame = cell.devices["camera"].frame(0.1).value
    seen = frame.plane_distance - frame.depth[frame.depth > 0].min()
    assert seen == pytest.approx(twin.contact(frame.time - 0.1).depth, abs=3e-4)
    assert seen < twin.contact(frame.time).depth - 3e-3


def over(mm, x=0.0):
    """Return a pose over a balloon, so many mm deep below its top."""
    return Pose((x, 0.0, 0.060 - 1e-3 * mm))


def dive(mm):
    """Return the poses of a lap without a sharp corner that is so many mm deep half way, and ends where it began."""
    return [over(mm * (1 - math.cos(t)) / 2, 0.02 * math.sin(t)) for t in np.linspace(0.0, 2 * math.pi, 61)]


def test_a_way_through_places_without_equilibrium_ends_where_there_is_one(make_cell, monkeypatch, clock, tmp_path):
    path = tmp_path / "balloon.yaml"
    path.write_text(
        "format: stretch-scene/1\nobject: {type: balloon, diameter: 60 mm, base: 30 mm, pressure: 2 kPa, fill: {type: seeds}}\n"
        "fidelity: hertz\neffects: {compliance: on, granular_hysteresis: on}\n"
    )
    cell = make_cell(scene=path)
    twin = cell._context.twin
    contact = twin.world.contact

    def none_half_way(pose, stretch, time):
        if 0.0 < time < clock.time:
            raise NoEquilibrium("none here")
        return contact(pose, stretch, time)

    monkeypatch.setattr(twin.world, "contact", none_half_way)
    cell.devices["arm"].follow([over(6)], speed=0.02, owner="a")
    clock.time += 5.0
    assert twin.contact(clock.time).force[2] > 0


WAYS = {"down and up": [[over(6), over(2)]], "a lap": [[over(0)], dive(6), [over(2)]]}


@pytest.mark.parametrize(("fill", "effect"), [("seeds", "granular_hysteresis"), ("water", "latex_softening")])
def test_an_object_remembers_the_middle_of_a_way(make_cell, advance, tmp_path, fill, effect):
    """As it does where the hand stops when it is deepest."""
    path = tmp_path / "balloon.yaml"
    path.write_text(
        f"format: stretch-scene/1\nobject: {{type: balloon, diameter: 60 mm, base: 30 mm, pressure: 2 kPa, fill: {{type: {fill}}}}}\n"
        f"fidelity: hertz\neffects: {{compliance: on, {effect}: on}}\n"
    )
    forces = {}
    for name, way in {"twice": [[over(6)], [over(2)]], "once": [[over(2)]], **WAYS}.items():
        cell = make_cell(scene=path)
        for poses in way:
            advance(cell.devices["arm"].follow(poses, speed=0.02, owner="a"))
        forces[name] = cell.truth()["force"]
    assert forces["twice"] < 0.99 * forces["once"]
    assert {name: forces[name] for name in WAYS} == pytest.approx(dict.fromkeys(WAYS, forces["twice"]), rel=1e-3)
