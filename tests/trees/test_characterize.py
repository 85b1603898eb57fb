"""characterize in the twin: it measures the scene's own forces, and an interruption costs nothing but time."""

import json
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Pose
from stretch_bt.hardware.simulated.operator import indenter
from stretch_bt.model.calibration.characterization import NAME, read_table
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.ticker import Planned
from stretch_bt.simulation.fidelity.make import Membrane
from stretch_bt.simulation.scene import load_scene
from stretch_bt.simulation.world import World

#: without noise, in closed form: differences between two runs are due to the runs alone
QUIET = """\
format: stretch-scene/1
object: {type: sphere, diameter: 30 mm, rigid: true}
fidelity: hertz
effects: none
"""
NOISY = QUIET.replace("none", "{force_sensor_noise: {sd: 20 mN}, repeatability: {sd: 0.05 mm}}")
SMALL = {
    "clearance": 0.02,
    "diameters": [0.02, 0.03],
    "stretches": [0.0, 0.04],
    "depths": [0.0, 0.002, 0.004],
    "trials": 2,
}
ROWS = 2 * 2 * 3 * 2
#: of interruptions: while an indenter is mounted; in the first trial, while the sensor is zeroed, before the last row
TICKS = [900, *(pytest.param(tick, marks=pytest.mark.slow) for tick in (470, 640, 1580))]


@pytest.fixture
def characterize(run, hand_at, tmp_path):
    def make(scene=QUIET, **options):
        path = tmp_path / "scene.yaml"
        path.write_text(scene)
        params = {**SMALL, **options.pop("params", {})}
        return run("characterize", cell=hand_at(80), scene=path, params=params, **options)

    return make


@pytest.fixture(scope="module")
def kept():
    """Return what is kept for the tests after: the result of a run that nothing interrupted."""
    return {}


@pytest.fixture
def undisturbed(characterize, kept):
    if "result" not in kept:
        kept["result"] = characterize()
    return kept["result"]


def table_of(result):
    return read_table(Path(result.record) / NAME)


def events_of(result):
    return [json.loads(line) for line in (Path(result.record) / "events.jsonl").read_text().splitlines()]


def commands(result, name):
    return [e["arguments"] for e in events_of(result) if e["type"] == "command" and e["name"] == name]


def known(scene_text, path, table):
    """Return what the scene's world knows of the force of each row, N."""
    path.write_text(scene_text)
    forces = []
    scene = load_scene(path)
    for press in table.presses():
        world = World(scene.with_(object=indenter(press.geometry, press.size, scene.object.position)), Membrane())
        pose = Pose((0.0, 0.0, press.contact_height - press.depth))
        forces.append(world.truth(pose, press.stretch)["force"])
    return np.array(forces)


def test_each_state_is_measured_once_in_order_with_the_fewest_changes(undisturbed, tmp_path):
    result = undisturbed
    assert result.status == "SUCCESS", result.reason
    assert (result.outputs["rows"]["value"], result.outputs["presses"]["value"]) == (ROWS, ROWS)
    table = table_of(result)
    assert [(p.size, p.stretch, p.trial, p.depth) for p in table.presses()] == [
        (size, pytest.approx(stretch), trial, pytest.approx(depth, abs=1e-12))
        for size in SMALL["diameters"]
        for stretch in SMALL["stretches"]
        for trial in (1, 2)
        for depth in SMALL["depths"]
    ]
    assert [c["size"] for c in commands(result, "mount")] == SMALL["diameters"]
    assert len(commands(result, "zero")) == 8
    assert table.force == pytest.approx(known(QUIET, tmp_path / "scene.yaml", table), rel=1e-6, abs=1e-9)
    tops = 0.040 + table.size
    assert table.contact_height == pytest.approx(tops, abs=2e-4)
    assert np.ptp(table.contact_height[:12]) == 0.0
    assert np.all(table.force_sd < 1e-9)


def test_each_trial_begins_from_a_retracted_hand(undisturbed):
    heights = []
    for event in events_of(undisturbed):
        if event["type"] == "command" and event["name"] == "zero":
            heights.append([])
        elif event["type"] == "command" and event["name"] == "move" and event["owner"] == "main/press":
            heights[-1].append(event["arguments"]["target"]["position"][2])
    assert len(heights) == 8
    for trial in heights:
        assert len(trial) == 3
        assert trial == sorted(trial, reverse=True)


def test_the_force_has_the_noise_that_it_states(characterize, tmp_path):
    result = characterize(NOISY, params={"diameters": [0.02], "stretches": [0.0, 0.02, 0.04], "trials": 4})
    table = table_of(result)
    # the unknown error of the arm's height is in the force as well, through the force's slope over depth
    steep = 1.5 * table.force / np.maximum(table.depth, 1e-3)
    sd = np.hypot(table.force_sd, steep * 5e-5)
    off = (table.force - known(QUIET, tmp_path / "quiet.yaml", table)) / sd
    assert 0.7 < np.sqrt(np.mean(off**2)) < 1.4
    assert np.median(table.force_sd) == pytest.approx(0.02 * np.hypot(1 / np.sqrt(10), 1 / np.sqrt(20)), rel=0.2)


@pytest.mark.parametrize("tick", TICKS)
def test_an_interrupted_run_is_gone_on_with(characterize, undisturbed, tmp_path, tick):
    whole = table_of(undisturbed)
    path = tmp_path / "table.csv"
    first = characterize(
        params={"table": str(path)}, watch=lambda runner: runner.ticker.planned.update({tick: [Planned(["SIGINT"])]})
    )
    assert first.status == "INTERRUPTED"
    measured = path.read_text().count("\n") - 2
    assert 0 < measured < ROWS
    with path.open("a") as file:
        file.write("sphere,20,,0,0.4")
    second = characterize(params={"table": str(path)})
    assert second.status == "SUCCESS", second.reason
    assert (second.outputs["rows"]["value"], second.outputs["presses"]["value"]) == (ROWS, ROWS - measured)
    table = read_table(path)
    for name in ("geometry", "size", "trial"):
        assert getattr(table, name).tolist() == getattr(whole, name).tolist()
    for name, close in (("stretch", 1e-9), ("depth", 1e-9), ("force", 2e-3), ("contact_height", 1e-4)):
        assert getattr(table, name) == pytest.approx(getattr(whole, name), abs=close), name
    for result in (first, second):
        assert replay(result.record).identical
        assert events_of(result)[0]["params"]["table"] == "table.csv"
    third = characterize(params={"table": str(path)})
    assert (third.status, third.outputs["presses"]["value"]) == ("SUCCESS", 0)
    assert commands(third, "mount") == []


def test_the_membrane_is_first_taken_where_it_is_softest(characterize):
    targets, said = [], []
    for condition in (True, False):
        result = characterize(
            params={
                "diameters": [0.02],
                "stretches": [0.01, 0.04],
                "depths": [0.0, 0.004],
                "trials": 1,
                "condition": condition,
            }
        )
        table = table_of(result)
        where = table.contact_height[0]
        said.append(table.provenance["conditioned"])
        owners = [e for e in events_of(result) if e["type"] == "command" and e["owner"].endswith("/soften/press")]
        targets.append([where - e["arguments"]["target"]["position"][2] for e in owners])
    assert targets == [[pytest.approx(0.004)], []]
    assert said == [{"stretch": 0.04, "depth": 0.004}, {"stretch": 0.0, "depth": 0.0}]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"stretches": ["200 mm"]}, "stretches: 200 mm .* 0 mm to 80 mm"),
        ({"depths": ["40 mm"]}, "depths: 40 mm .* 0 mm to 30 mm"),
        ({"table": "none/table.csv"}, "there is no folder none"),
    ],
)
def test_what_no_run_can_reach_ends_before_anything_moves(characterize, tmp_path, wrong, said):
    record = tmp_path / "record"
    with pytest.raises(InvalidInput, match=said):
        characterize(params=wrong, out=record)
    assert not record.exists()


def test_too_much_force_ends_the_task_and_raises_the_hand(characterize):
    runners = []
    result = characterize(params={"max_force": 0.3}, watch=runners.append)
    assert result.status == "FAILURE"
    assert "0.3 N" in result.reason
    assert runners[0].cell.truth()["force"] == 0.0
