"""The force at a press, and the zero that is taken off it."""

import math

import pytest

from stretch_bt import run
from stretch_bt.tree.ports import Status

ALONE = """\
format: stretch-tree/1
devices: {gripper: Gripper, force_sensor: ForceSensor}
scene: calibration_sphere
trees:
  main:
    out: {force: Force}
    sequence:
      - zero_force: {count: 3}
      - set_stretch: {stretch: 10 mm}
      - measure_force: {count: 3, force: $force}
"""


def force_of(node):
    return node.sinks["force"].value, node.sinks["force"].sd


def test_a_force_is_the_mean_along_the_axis_with_its_standard_error(bench, saying):
    sensor = saying([(0.3, 0.0, 1.0), (0.1, 0.2, 1.2), (0.0, 0.0, 1.4), (0.0, 0.0, 99.0)])
    node = bench(force_sensor=sensor).run("measure_force", count=3)
    assert force_of(node) == pytest.approx((1.2, 0.2 / math.sqrt(3)))


def test_the_axis_is_that_of_the_hand(bench, saying):
    made = bench(force_sensor=saying([(0.0, -1.0, 0.0), (0.0, -1.2, 0.0)]))
    made.stand(0.055, rotation=(math.pi / 2, 0.0, 0.0))
    assert force_of(made.run("measure_force", count=2))[0] == pytest.approx(1.1)


def test_noise_does_not_raise_the_force_of_nothing(bench, saying):
    node = bench(force_sensor=saying([(0.1, -0.1, 0.02), (-0.1, 0.1, -0.02)])).run("measure_force", count=2)
    assert force_of(node) == pytest.approx((0.0, 0.02))


def test_a_reading_counts_once(bench, saying):
    made = bench(force_sensor=saying([1.0, 5.0, 5.0, 2.0], numbers=[7, 7, 7, 8]))
    node = made.node("measure_force", count=2)
    assert made.tick(node, 3) is Status.RUNNING
    assert made.tick(node) is Status.SUCCESS
    assert force_of(node)[0] == pytest.approx(1.5)


def test_a_reading_from_before_does_not_count(bench, saying):
    sensor = saying([1.0, 2.0, 3.0, 3.0])
    made = bench(force_sensor=sensor)
    made.context.now, sensor.now = 5.0, lambda: 4.9
    node = made.node("measure_force", count=2)
    assert made.tick(node) is Status.RUNNING
    sensor.now = lambda: 6.0
    assert made.tick(node, 2) is Status.SUCCESS
    assert force_of(node) == pytest.approx((2.5, 0.5))


def test_what_is_left_after_zeroing_is_taken_off_with_its_error(bench, saying):
    sensor = saying([0.1, 0.3, 1.0, 1.0, 1.6])
    made = bench(force_sensor=sensor)
    zero = made.run("zero_force", count=2)
    assert (sensor.zeroed, zero.sinks["offset"].value) == (1, pytest.approx(0.2))
    force = force_of(made.run("measure_force", count=3))
    assert force == pytest.approx((1.0, math.hypot(0.1, 0.2)))


def test_a_sensor_without_new_readings_is_refused(bench, saying):
    node = bench(force_sensor=saying([1.0], numbers=[3])).run("measure_force", count=5)
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
def test_a_sensor_that_says_one_force_everywhere_is_stuck(bench, saying, before, after, heights, stuck):
    made = bench(force_sensor=saying(before * 2))
    made.stand(heights[0])
    made.run("measure_force", count=len(before))
    made.stand(heights[1])
    made.context.devices["force_sensor"].forces = after * 4
    node = made.run("measure_force", count=3)
    assert (node.status, node.reason) == ((Status.FAILURE, STUCK) if stuck else (Status.SUCCESS, ""))


def test_a_sensor_that_still_says_what_it_said_when_it_was_zeroed_is_stuck(bench, saying):
    made = bench(force_sensor=saying([0.5]))
    made.stand(0.080)
    made.run("zero_force", count=2)
    made.stand(0.055)
    assert made.run("measure_force", count=2).reason == STUCK


def test_a_sensor_that_is_stuck_stays_so_when_it_is_asked_again(bench, saying):
    made = bench(force_sensor=saying([0.5]))
    for height in (0.056, 0.055):
        made.stand(height)
        made.run("measure_force", count=2)
    made.stand(0.053)
    assert made.run("measure_force", count=2).reason == STUCK


def test_before_first_contact_is_known_no_sensor_is_called_stuck(bench, saying):
    made = bench(force_sensor=saying([0.5]))
    for height in (0.056, 0.050):
        made.stand(height)
        assert made.run("measure_force", touch=None, count=2).status is Status.SUCCESS


def test_without_an_arm_the_hand_points_straight_down(tmp_path):
    (tmp_path / "alone.yaml").write_text(ALONE)
    result = run(tmp_path / "alone.yaml", out=tmp_path / "record")
    assert result.status == "SUCCESS", result.reason
    assert result.outputs["force"]["value"] == pytest.approx(0.0, abs=0.2)
