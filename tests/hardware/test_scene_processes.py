"""The twin behind stand-ins, in a process of its own: they feel and see it where the hand is."""

import math
import os
import socket
import time
from contextlib import ExitStack

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lab import lab_cell
from waiting import eventually

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.channel import Channel
from stretch_bt.hardware.emulators.ati import AtiStandIn
from stretch_bt.hardware.emulators.height_error import HeightError
from stretch_bt.hardware.emulators.messages import SCENE, TWIN, FeltForce, HandAt, Renew, Solve
from stretch_bt.hardware.emulators.pictures import Pictures, picture_memory
from stretch_bt.hardware.emulators.remote import Process
from stretch_bt.hardware.emulators.serve import serving_elsewhere
from stretch_bt.hardware.emulators.setting import Setting
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.twin_camera import lens
from stretch_bt.hardware.emulators.twin_process import steadied, take
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.simulated.placed import Placed
from stretch_bt.hardware.simulated.trace import Trace
from stretch_bt.hardware.simulated.twin import Twin
from stretch_bt.simulation.camera.sensor import Sensor
from stretch_bt.simulation.scene import load_scene

DEVICES = {
    "arm": {"watchdog": "1 Hz", "lost_after": "2 s", "heartbeat": "5 s", "force_filter": "500 ms"},
    "gripper": {},
    "force_sensor": {},
    "camera": {"lost_after": "5 s"},
}
QUIET = """\
format: stretch-scene/1
object: {type: sphere, diameter: 30 mm, rigid: true}
effects: {arm_force_noise: {sd: 1 mN}, force_sensor_noise: {sd: 1 mN}, fixed_pattern: off}
"""
TWIN_PROCESS = "stretch_bt.hardware.emulators.twin_process"
#: where the hand is above the lump, pressing it, and after it rolled it, (x, height), m; and by how much it goes on at once, m
ABOVE, PRESSING, ASIDE, STEP = (0.0, 0.030), (0.0, 0.015), (0.015, 0.015), 2e-4
STRETCH, HEIGHT = 0.02, 0.024


def test_stand_ins_feel_and_see_the_twin_where_the_hand_is(tmp_path, own_hosts, librealsense):
    """The arm takes its membrane down, the gripper stretches it, arm and sensor feel it, the camera sees it, all through their wires."""
    host, geometry, scene = next(own_hosts), HandGeometry(), tmp_path / "scene.yaml"
    scene.write_text(QUIET)
    names = ["ur", "robotiq", "ati", "realsense"]
    with serving_elsewhere(names, scene=str(scene), host=host, activated=True) as servers:
        path = tmp_path / "cell.yaml"
        path.write_text(lab_cell(host, DEVICES))
        cell = open_cell(load_cell(path), now=time.monotonic)
        try:
            arm, gripper, sensor, camera = (cell.devices[name] for name in DEVICES)
            opened = gripper.move(geometry.opening(STRETCH), speed=0.1, owner="test")
            eventually(lambda: opened.poll() == "done")
            down = arm.move(Pose((0.0, 0.0, HEIGHT)), speed=0.1, owner="test")
            eventually(lambda: down.poll() == "done")
            twin = Twin(load_scene(scene), geometry, lambda: 0.0, 0)
            stretch = geometry.stretch(servers.stand_ins["robotiq"].state()["opening"])
            pose = arm.pose(5.0).value
            contact = twin.world.contact(pose, stretch)
            assert contact.force[2] > 0.5
            for device in (arm, sensor):
                eventually(lambda one=device: abs(one.wrench(5.0).value.force[2] - contact.force[2]) < 0.02)
            twin.place(pose)
            twin.fingers = type(twin.fingers)(geometry.opening(stretch))
            wanted = Sensor(twin.world, lens(geometry), geometry.plane_distance, 30, twin.random).clean(
                twin.shot(0.0, 0)
            )
            eventually(lambda: difference(camera.frame(5.0).value, wanted) < 5e-5)
        finally:
            assert cell.close() == []


def difference(frame, wanted):
    """Return how far apart two depth images are in the median of the pixels that both have, m."""
    seen = frame.raw * frame.unit
    both = (seen > 0) & (wanted > 0)
    assert both.mean() > 0.7
    assert ((seen > 0) == (wanted > 0)).mean() > 0.99
    return float(np.median(np.abs(seen - wanted)[both]))


def test_an_object_goes_back_to_what_it_was_with_every_new_cell(tmp_path, own_hosts):
    """Each new serving knows nothing of the one before, and none of its processes is left."""
    scene = tmp_path / "scene.yaml"
    scene.write_text(QUIET + "fidelity: hertz\n")
    for _ in range(2):
        with serving_elsewhere(["ur"], scene=str(scene), host=next(own_hosts)) as servers:
            pids = [process.pid for process in servers.processes]
            assert servers.stand_ins["ur"].state()["height"] == pytest.approx(0.2)
        assert not any(os.path.exists(f"/proc/{pid}") for pid in pids)  # noqa: PTH110


@given(st.lists(st.floats(-1e-3, 1e-3), min_size=1, max_size=30))
def test_a_hand_that_hardly_moves_stands_and_one_that_moves_is_where_it_is(steps):
    pose, six = Pose((0.0, 0.0, 0.1)), [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]
    for step in steps:
        six = [six[0] + step, six[1], six[2] - step, six[3], six[4], six[5] + step]
        before, pose = pose, steadied(pose, six)
        assert np.abs(np.subtract((*pose.position, *pose.rotation), six)).max() <= 1e-5
        assert abs(pose.height - six[2]) <= 2e-6
        assert steadied(pose, [*pose.position, *pose.rotation]) == pose
        if abs(six[0] - before.position[0]) < 0.7e-5:
            assert pose.position[0] == before.position[0]


def test_a_trace_is_straight_between_what_was_noted_and_stands_where_nothing_was():
    trace = Trace(Placed.at(Pose((0.0, 0.0, 0.2))), Placed.between, 0.05)
    for time_, height in ((1.0, 0.1), (1.008, 0.09), (3.0, 0.05)):
        trace.note(time_, Placed.at(Pose((0.0, 0.0, height))))
    heights = [trace.at(time_).true.height for time_ in (0.5, 1.0, 1.004, 1.008, 2.9, 3.0, 9.0)]
    assert heights == pytest.approx([0.2, 0.1, 0.095, 0.09, 0.09, 0.05, 0.05])


def test_a_picture_is_whole_until_three_others_were_left_after_it():
    descriptor = picture_memory()
    writer, reader = Pictures(os.dup(descriptor), (3, 4)), Pictures(descriptor, (3, 4))
    numbers = [writer.put(np.full((3, 4), float(k), np.float32)) for k in range(10)]
    assert len(set(numbers)) == 10  # so that nobody takes one for another
    for k, number in list(enumerate(numbers))[-4:]:
        assert (reader.get(number) == k).all()


#: a scene's effects, and the noise of arm and force sensor, N an axis, that stand-ins take from it; None where each keeps its own
NOISES = {
    "auto": (None, None),
    "none": (0.0, 0.0),
    "all": (0.1, 0.02),
    "{arm_force_noise: {sd: 0 N}}": (0.0, None),
    "{arm_force_noise: off, force_sensor_noise: on}": (0.0, 0.02),
    "{arm_force_noise: {sd: 2 N}, force_sensor_noise: off}": (2.0, 0.0),
}


@pytest.mark.parametrize("effects", NOISES)
def test_a_stand_in_has_the_noise_that_the_scene_says(tmp_path, effects):
    """The force sensor's is measured: a sensor without noise gives the same counts again and again."""
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "format: stretch-scene/1\nobject: {type: sphere, diameter: 30 mm, rigid: true}\n"
        f"tolerance: {{height: 0.1 mm}}\nfidelity: hertz\neffects: {effects}\n"
    )
    sds = Twin(load_scene(scene), HandGeometry(), lambda: 0.0, 0).force_noises()
    assert (sds.get("Arm"), sds.get("ForceSensor")) == NOISES[effects]
    sensor = AtiStandIn("127.0.0.1", StandInWorld())
    sensor.stage.force_noise = sds.get
    measured = np.array([sensor._measured()[:3] for _ in range(400)]) / 1e6
    assert measured.std() == pytest.approx(sds.get("ForceSensor", 0.002), rel=0.1)


class Pressed:
    """The process of a twin around a scene, with a stand-in that only takes the hand up and down and feels."""

    def __init__(self, scene, stack):
        memory = os.fdopen(picture_memory(), "rb")
        here, there = socket.socketpair()
        setting = Setting(scene, 0, time.monotonic())
        self.process = Process(
            "the twin", TWIN_PROCESS, TWIN, Solve(setting, [["felt"]]), [memory.fileno(), there.fileno()]
        )
        stack.callback(self.process.end)
        stack.enter_context(memory)
        self.setting, self.wire = setting, Channel(stack.enter_context(here), SCENE)
        there.close()
        self.process.answer(120.0)

    def move(self, begin, end):
        """Take the hand from a place (x, height), m, to another at 30 mm/s."""
        for x, height in np.linspace(begin, end, 2 + int(math.dist(begin, end) / STEP)).tolist():
            self.wire.send(HandAt(self.setting.now(), [x, 0.0, height, 0.0, 0.0, 0.0]))
            time.sleep(STEP / 0.03)

    def felt(self, begin, end):
        """Return the upward force, N, a second after the hand went from a place to another."""
        self.move(begin, end)
        time.sleep(1.0)
        return [message for message in self.wire.drain() if isinstance(message, FeltForce)][-1].forces["Arm"][2]


def test_a_new_object_is_as_the_first_one_was(at_hertz, tmp_path):
    with ExitStack() as stack:
        pressed = Pressed(str(at_hertz("dough_cube", tmp_path)), stack)
        first = pressed.felt(ABOVE, PRESSING)
        assert first > 0.1
        with pytest.raises(InvalidInput, match="the hand touches the object; raise it first"):
            pressed.process.ask(Renew())
        pressed.move(PRESSING, ASIDE)
        assert pressed.felt(ASIDE, ABOVE) == 0.0
        used = pressed.felt(ABOVE, PRESSING)
        assert pressed.felt(PRESSING, ABOVE) == 0.0
        pressed.process.ask(Renew())
        assert pressed.felt(ABOVE, PRESSING) == pytest.approx(first, rel=0.05)
        assert abs(used - first) > 0.2 * first


@pytest.mark.parametrize("sd", [0.0, 5e-5])
def test_each_move_ends_a_little_off_where_the_scene_says_so(tmp_path, sd):
    scene = tmp_path / "scene.yaml"
    on = f"{{sd: {sd} m}}" if sd else "off"
    scene.write_text(
        f"format: stretch-scene/1\nobject: {{type: sphere, diameter: 30 mm, rigid: true}}\neffects: {{repeatability: {on}}}\n"
    )
    twin = Twin(load_scene(scene), HandGeometry(), lambda: 0.0, 0)
    error, ends, time = HeightError(twin), [], 0.0
    for move in range(400):
        begin, end = (0.150, 0.140) if move % 2 else (0.140, 0.150)
        for height in np.linspace(begin, end, 11)[1:].tolist():
            time += 0.008
            take(twin, error, HandAt(time, [0.0, 0.0, height, 0.0, 0.0, 0.0]))
        time += 0.5
        placed = twin.hand.at(time)
        assert placed.told.height == pytest.approx(end)
        ends.append(placed.true.height - placed.told.height)
    assert np.std(ends) == pytest.approx(sd, rel=0.15)
    assert abs(np.mean(ends)) <= 3 * sd / 20
