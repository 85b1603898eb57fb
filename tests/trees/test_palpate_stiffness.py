"""palpate_stiffness in the twin, against what the scene knows at the instant of the answer."""

import re
from itertools import pairwise

import pytest

from stretch_bt.runtime.ticker import Planned


@pytest.mark.parametrize(
    ("scene", "seed"),
    [
        pytest.param("air_balloon", 0, marks=pytest.mark.slow),
        pytest.param("water_balloon", 1, marks=pytest.mark.slow),
        pytest.param("pudding_balloon", 2, marks=pytest.mark.slow),
        ("seeds_balloon", 3),
    ],
)
def test_each_output_lies_by_the_truth_within_its_stated_error(run, hand_at, scene, seed):
    result = run("palpate_stiffness", cell=hand_at(75), scene=scene, seed=seed)
    assert result.status == "SUCCESS", result.reason
    for name in ("stiffness", "force", "deflection", "radius"):
        output, truth = result.outputs[name], result.truth[name]
        assert output["unit"] == truth["unit"]
        assert abs(output["value"] - truth["value"]) < 4 * output["sd"], name
    assert result.outputs["deflection"]["value"] >= 1.5
    assert result.outputs["stiffness"]["value"] == pytest.approx(
        result.outputs["force"]["value"] / result.outputs["deflection"]["value"]
    )
    assert result.outputs["stiffness"]["sd"] < 0.25 * result.outputs["stiffness"]["value"]


def test_a_depth_limit_below_the_first_press_is_refused_before_moving(run):
    result = run("palpate_stiffness", params={"max_depth": 0.005})
    assert result.status == "FAILURE"
    assert result.reason.startswith("main/depth_allowed: ")


def test_the_hand_is_clear_of_the_object_however_the_approach_ends(run):
    runners = []

    def stop_while_feeling(runner):
        runners.append(runner)
        runner.ticker.planned = {180: [Planned(["SIGINT"])]}

    result = run("palpate_stiffness", scene="seeds_balloon", watch=stop_while_feeling)
    assert result.status == "INTERRUPTED"
    assert runners[0].cell.truth()["force"] == 0.0


NOISY = """format: stretch-scene/1
object: {type: sphere, diameter: 60 mm, stiffness: 0.9 N/mm}
fidelity: hertz
tolerance: {stiffness: 5 %, height: 0.3 mm}
effects: {white_noise: on, correlated_noise: on, fixed_pattern: on, drift: on, quantisation: on, dropout: on, flying_pixels: on}
"""


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 3])
def test_all_noise_of_the_bench_camera_is_borne(run, tmp_path, seed):
    scene = tmp_path / "noisy.yaml"
    scene.write_text(NOISY, encoding="utf-8")
    result = run("palpate_stiffness", scene=scene, seed=seed)
    assert result.status == "SUCCESS", result.reason
    stiffness, radius = result.outputs["stiffness"], result.outputs["radius"]
    assert abs(stiffness["value"] - 0.9) < 3 * stiffness["sd"] < 0.3
    assert abs(radius["value"] - 30.0) < 3 * radius["sd"] < 9.0
    assert result.outputs["deflection"]["value"] >= 1.5


SPRING = """format: stretch-scene/1
object: {type: soft_sphere, diameter: 60 mm, stiffness: 0.2 N/mm, power: 1}
tolerance: {stiffness: 5 %, height: 0.3 mm}
effects: {white_noise: on, correlated_noise: on, fixed_pattern: on, drift: on, quantisation: on, dropout: on, flying_pixels: on}
"""


@pytest.mark.slow
def test_a_soft_spring_is_pressed_until_the_readings_tell_that_it_is_one(run, tmp_path):
    """The prior of the power is not of springs: three touches and a press to 1.5 mm read it a tenth soft."""
    scene = tmp_path / "spring.yaml"
    scene.write_text(SPRING, encoding="utf-8")
    result = run("palpate_stiffness", scene=scene, seed=1, params={"model": "membrane"})
    assert result.status == "SUCCESS", result.reason
    assert result.outputs["stiffness"]["value"] == pytest.approx(0.2, rel=0.05)
    assert result.outputs["deflection"]["value"] > 2.7


RIGID = """format: stretch-scene/1
object: {type: sphere, diameter: 60 mm, rigid: true}
fidelity: hertz
effects: {white_noise: on, correlated_noise: on, fixed_pattern: on}
"""


@pytest.mark.slow
def test_an_object_that_does_not_deform_is_refused_with_the_least_that_its_stiffness_is(run, tmp_path):
    scene = tmp_path / "rigid.yaml"
    scene.write_text(RIGID, encoding="utf-8")
    result = run("palpate_stiffness", scene=scene, params={"max_force": 3.0})
    assert result.status == "FAILURE"
    assert "too little to tell; its stiffness is above about" in result.reason
    assert float(re.search(r"under (\S+) N", result.reason)[1]) > 1.0, "it was pressed before it was refused"


@pytest.mark.slow
def test_a_shallow_limit_of_depth_is_made_up_by_stretch_at_a_force_that_never_falls(run, pressed):
    forces, watch = pressed
    params = {"max_depth": 0.011, "sensing_depth": 0.010}
    result = run("palpate_stiffness", scene="seeds_balloon", seed=4, params=params, watch=watch)
    assert result.status == "SUCCESS", result.reason
    assert result.outputs["stretch"]["value"] > 0
    assert len(forces) == result.outputs["presses"]["value"] >= 2
    assert all(after > 0.98 * before for before, after in pairwise(forces))


@pytest.mark.slow
def test_what_gives_way_for_seconds_is_held_and_the_time_is_told(run):
    result = run("palpate_stiffness", scene="pudding_balloon", seed=1, params={"min_hold": 5.0, "settle": 3.0})
    assert result.status == "SUCCESS", result.reason
    assert result.outputs["hold"]["value"] >= 5.0
    assert abs(result.outputs["stiffness_at_drop"]["value"] - 0.607) < 3 * result.outputs["stiffness_at_drop"]["sd"]


CREEPS = """format: stretch-scene/1
object:
  type: balloon
  diameter: 60 mm
  base: 30 mm
  pressure: 4 kPa
  fill: {type: pudding, modulus: 20 kPa, sudden: 20 kPa, time: 60 s}
support: {type: cup, diameter: 60 mm, rim: 30 mm}
fidelity: hertz
effects: {white_noise: on, correlated_noise: on}
"""


def test_what_keeps_creeping_is_told_as_it_is_then_after_no_more_than_the_longest_hold(run, hand_at, tmp_path):
    scene = tmp_path / "creeps.yaml"
    scene.write_text(CREEPS, encoding="utf-8")
    result = run("palpate_stiffness", cell=hand_at(75), scene=scene, seed=1, params={"max_hold": 6.0})
    assert result.status == "SUCCESS", result.reason
    stiffness, truth = result.outputs["stiffness"], result.truth
    now = truth["force"]["value"] / truth["deflection"]["value"]
    assert now > 1.1 * truth["stiffness"]["value"], "which is the settled object's"
    assert abs(stiffness["value"] - now) < 3 * stiffness["sd"] < 0.5 * now
    assert 3.5 <= result.outputs["hold"]["value"] < 8.0


STIFF = """format: stretch-scene/1
object: {type: sphere, diameter: 60 mm, stiffness: 5 N/mm}
fidelity: hertz
tolerance: {stiffness: 5 %, height: 0.3 mm}
"""


@pytest.mark.parametrize("tree", ["palpate_stiffness", pytest.param("palpate_active", marks=pytest.mark.slow)])
def test_a_stiff_object_ends_with_the_stiffness_that_it_showed(run, hand_at, tmp_path, tree):
    scene = tmp_path / "stiff.yaml"
    scene.write_text(STIFF, encoding="utf-8")
    result = run(tree, cell=hand_at(75), scene=scene, params={"max_force": 5.5})
    shown, truth = result.outputs["stiffness"], result.truth["stiffness"]
    assert abs(shown["value"] - truth["value"]) < 4 * shown["sd"] < truth["value"]
    if tree == "palpate_stiffness":
        assert result.status == "FAILURE"
        assert "gave way by" in result.reason
        assert f"which is {shown['value']:.3g}"[:9] in result.reason


STILL = """\
format: stretch-mocks/1
tree: {tree}
readings: {{arm.force: 1 N}}
mocks:
  - {{match: main/approach, outputs: {{touch: {{height: 60 mm, height_sd: 0.01 mm}}}}}}
  - {{match: "**/press"}}
  - {{match: main/feel_first, outputs: {{sphere: {{radius: 30 mm, radius_sd: 0.2 mm}}, felt: {first}}}}}
  - {{match: "**/feel", outputs: {{sphere: {{radius: 30 mm, radius_sd: 0.2 mm}}, felt: {second}}}}}
  - {{match: "**/list_presses", outputs: {{candidates: {{count: 3}}}}}}
  - {{match: "**/plan_*", status: [success, failure], outputs: {{{plan}}}}}
  - {{match: "**/retract"}}
  - {{match: "**/set_stretch"}}
"""
FELT = (
    "{{deflection: {deflection}, deflection_sd: 0.01 mm, force: {force}, force_sd: 0.1 N, correlation: 0, "
    "creep: 0 mm, creep_sd: 0.01 mm}}"
)


@pytest.mark.parametrize(("tree", "more"), [("palpate_stiffness", ""), ("palpate_active", ", frames: 4, known: false")])
def test_what_a_failed_run_tells_is_all_of_one_look(run, tree, more):
    """The second look no longer shows that the object gave way; its force must not stand beside the stiffness of the first."""
    first = FELT.format(deflection="1 mm", force="2 N")
    second = FELT.format(deflection="0.02 mm", force="3 N")
    plan = f"next: {{stretch: 0 mm, depth: 12 mm{more}}}"
    result = run(tree, mocks=STILL.format(tree=tree, first=first, second=second, plan=plan))
    assert result.status == "FAILURE", result.reason
    assert "plan_" in result.reason
    found = {name: result.outputs[name]["value"] for name in ("stiffness", "force", "deflection")}
    assert found == pytest.approx({"stiffness": 2.0, "force": 2.0, "deflection": 1.0})
