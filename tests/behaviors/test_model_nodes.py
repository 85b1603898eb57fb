"""Nodes that compute: each value they write carries its error, and a question without an answer is a FAILURE with its reason."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.behaviors.records import Mounting
from stretch_bt.errors import InvalidInput
from stretch_bt.model import CalibratedHertz, ForceModel, hertz_force
from stretch_bt.perception.pattern import HANG
from stretch_bt.runtime.check import check
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.ports import MISSING, Behavior, Cell, Role, Status
from stretch_bt.tree.registry import lookup

radii = st.floats(0.006, 0.040)
stretches = st.floats(0.0, 0.060)
depths = st.floats(0.004, 0.014)


def made(name: str, **inputs: Any) -> Behavior:
    info = lookup(name)
    assert info is not None
    node = info.cls(f"main/{name}")
    node.context = RunContext()
    for port in info.of(Role.INPUT):
        node.wiring[port.name] = partial(inputs.get, port.name, port.default)
    return node


def run(name: str, **inputs: Any) -> tuple[Behavior, Cell]:
    node = made(name, **inputs)
    for _ in node.tick():
        pass
    return node, next(iter(node.sinks.values()))


def mounting_by(**inputs: Any) -> Mounting:
    """Return what a model predicts of the free membrane."""
    node, found = run("predict_sag", **inputs)
    assert node.status is Status.SUCCESS, node.reason
    mounting: Mounting = found.value
    return mounting


@given(radius=radii, stretch=stretches, depth=depths)
def test_the_next_indentation_gives_the_same_force(radius: float, stretch: float, depth: float) -> None:
    _, force = run("predict_force", radius=radius, stretch=stretch, depth=depth)
    node, start = run("next_indentation", radius=radius, stretch=stretch, force=force.value)
    assert node.status is Status.SUCCESS
    assert start.value == pytest.approx(depth, rel=1e-6)
    _, harder = run("next_indentation", radius=radius, stretch=stretch + 0.02, force=force.value)
    assert harder.value < depth, "a tenser membrane needs less depth"


def test_a_sag_is_predicted_by_a_model_that_knows_the_membrane() -> None:
    slack = mounting_by(model="membrane")
    assert slack.sag == pytest.approx(0.606e-3, rel=0.02)
    assert 0.03e-3 < slack.sag_sd < 0.1e-3
    assert slack.prestretch > 0
    tighter = mounting_by(model="membrane", stretch=0.03)
    assert tighter.sag < 0.5 * slack.sag
    assert tighter.prestretch == slack.prestretch, "the mounts are as they were"


def test_a_model_that_knows_nothing_of_the_membrane_gives_what_such_membranes_do() -> None:
    assert mounting_by(model="paper") == Mounting(0.0, HANG.value, HANG.sd)


@given(radius=radii, stretch=stretches, depth=depths)
def test_the_chosen_stretch_gives_the_wanted_force(radius: float, stretch: float, depth: float) -> None:
    _, force = run("predict_force", radius=radius, stretch=stretch, depth=depth)
    node, found = run("choose_stretch", radius=radius, depth=depth, force=force.value)
    assert node.status is Status.SUCCESS
    assert found.value == pytest.approx(stretch, abs=1e-6)
    assert found.sd is not None
    assert found.sd >= 0


@pytest.mark.parametrize(
    ("force", "most", "stretch"),
    [(0.0, 0.05, 0.0), (100.0, 0.05, 0.05)],
    ids=["the slack membrane presses harder already", "no stretch is hard enough"],
)
def test_the_nearest_stretch_will_do_where_that_is_wanted(force: float, most: float, stretch: float) -> None:
    given_ = {"radius": 0.01, "depth": 0.005, "force": force, "max_stretch": most}
    node, found = run("choose_stretch", **given_, nearest=True)
    assert (node.status, found.value) == (Status.SUCCESS, stretch)


def test_no_stretch_above_the_largest_is_chosen() -> None:
    press = {"radius": 0.01, "depth": 0.008}
    force = run("predict_force", **press, stretch=0.06)[1].value
    node, _ = run("choose_stretch", **press, force=force, max_stretch=0.03)
    assert (node.status, "60 mm, above 30 mm" in node.reason) == (Status.FAILURE, True), node.reason
    node, found = run("choose_stretch", **press, force=force, max_stretch=0.03, nearest=True)
    assert (node.status, found.value) == (Status.SUCCESS, 0.03)


@given(radius=radii, stretch=stretches, depth=depths, sd=st.floats(1e-5, 1e-3))
def test_the_error_of_a_force_grows_with_those_of_radius_and_depth(
    radius: float, stretch: float, depth: float, sd: float
) -> None:
    given_ = {"radius": radius, "stretch": stretch, "depth": depth}
    sds = [run("predict_force", **given_, **more)[1].sd for more in ({}, {"radius_sd": sd}, {"depth_sd": sd})]
    assert all(value is not None and value > 0 for value in sds)
    assert sds[1] > sds[0] < sds[2]  # type: ignore[operator]


def test_above_the_membrane_there_is_no_force() -> None:
    node, force = run("predict_force", radius=0.02, stretch=0.0, depth=-0.001)
    assert (node.status, force.value) == (Status.SUCCESS, 0.0)


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("estimate_stiffness", {"force": 1.0, "deflection": 0.001, "deflection_sd": 0.0005}),
        ("estimate_stiffness", {"force": 1.0, "deflection": -0.001}),
        (
            "estimate_yield_stress",
            {"force": 0.1, "force_sd": 0.1, "edge": 0.025, "height": 0.022},
        ),
        (
            "estimate_modulus",
            {"force": 1.0, "deflection": 0.001, "deflection_sd": 0.0006, "depth": 0.01, "radius": 0.02},
        ),
        ("choose_stretch", {"radius": 0.01, "depth": 0.005, "force": 100.0}),
    ],
)
def test_what_has_no_answer_fails_with_its_reason_and_writes_nothing(name: str, inputs: dict[str, float]) -> None:
    node, written = run(name, **inputs)
    assert node.status is Status.FAILURE
    assert len(node.reason) > 20
    assert written.value is MISSING


def test_the_modulus_is_that_of_the_papers_sphere() -> None:
    force = hertz_force("sphere", 0.012, 9e3, radius=0.02, object_modulus=40e3)
    depth = (force * 0.75 / (4 / 3 * 9e3 * 0.02**0.5)) ** (2 / 3)
    given_ = {"force": force, "deflection": 0.012 - depth, "depth": depth, "radius": 0.02, "radius_sd": 0.001}
    node, modulus = run("estimate_modulus", **given_)
    assert node.status is Status.SUCCESS
    assert modulus.value == pytest.approx(40e3)
    assert modulus.sd == pytest.approx(40e3 * 0.025, rel=1e-3)


def test_stiffness_is_the_force_over_what_was_lost() -> None:
    node, stiffness = run("estimate_stiffness", force=1.5, deflection=0.0015, force_sd=0.03, deflection_sd=0.00003)
    assert (node.status, stiffness.value) == (Status.SUCCESS, pytest.approx(1000.0))
    assert stiffness.sd == pytest.approx(1000 * (0.02**2 + 0.02**2) ** 0.5, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "needs"),
    [
        ("plan_press", {"candidates", "felt"}),
        ("plan_look", {"candidates", "felt", "top_readings"}),
        ("list_presses", {"touch", "sphere", "felt"}),
        ("stiffness_at", {"felt"}),
        ("fit_deflection", {"touch", "sphere", "top_readings"}),
    ],
)
def test_what_follows_from_an_object_that_was_felt_needs_one_before_the_run(
    name: str, needs: set[str], tmp_path: Path
) -> None:
    file = tmp_path / "task.yaml"
    deflection = "" if name in ("list_presses", "fit_deflection") else "deflection: 1 mm"
    file.write_text(
        f"format: stretch-tree/1\ntrees:\n  main:\n    sequence:\n      - {name}: {{{deflection}}}\n", encoding="utf-8"
    )
    errors = [d.message for d in check([file]) if d.severity == "error"]
    assert {word for word in needs if any(word in message for message in errors)} == needs, errors


def calibrated_to(folder: Path, stretch: float) -> str:
    """Return a calibration file of a model that holds up to a stretch, m."""
    model = ForceModel.default()
    assert isinstance(model, CalibratedHertz)
    path = folder / "hand.json"
    replace(model, range=replace(model.range, stretch=(0.0, stretch))).save(path)
    return str(path)


def test_a_model_that_does_not_reach_the_largest_stretch_is_refused_before_the_run(tmp_path: Path) -> None:
    short = calibrated_to(tmp_path, 0.06)
    node = made("list_presses", model=short)
    with pytest.raises(
        InvalidInput, match=r"max_stretch: 80 mm is past 60 mm, up to which the model '.*hand.json' holds"
    ):
        node.prepare()
    for inputs in ({"model": short, "max_stretch": 0.06}, {"model": "paper"}, {"model": "fitted"}):
        made("list_presses", **inputs).prepare()


def test_the_nearest_stretch_is_the_models_own_end_or_a_refusal(tmp_path: Path) -> None:
    model = ForceModel.default()
    assert isinstance(model, CalibratedHertz)
    file = tmp_path / "hand.json"
    replace(model, range=replace(model.range, stretch=(0.01, 0.06))).save(file)
    press = {"radius": 0.01, "depth": 0.005, "nearest": True}
    cases: list[tuple[dict[str, Any], float | str]] = [
        ({"model": str(file), "force": 0.001}, 0.01),
        ({"model": str(file), "force": 100.0}, 0.06),
        ({"model": str(file), "force": 0.001, "max_stretch": 0.005}, "stretch 5 mm"),
        ({"model": "membrane", "force": 1.0, "depth": 0.026}, "depth 26 mm"),
        ({"model": "membrane", "force": 1.0, "radius": 0.07}, "radius 70 mm"),
    ]
    for inputs, expected in cases:
        node, found = run("choose_stretch", **press | inputs)
        if isinstance(expected, float):
            assert (node.status, found.value) == (Status.SUCCESS, expected), inputs
        else:
            assert (node.status, expected in node.reason) == (Status.FAILURE, True), (inputs, node.reason)


@pytest.mark.parametrize(
    ("radius", "sd"), [(0.0042, 0.0005), (0.0598, 0.0005), (0.02, 1.0)], ids=["smallest", "largest", "unknown"]
)
def test_the_error_of_a_radius_near_the_end_of_the_range_counts(radius: float, sd: float) -> None:
    press = {"model": "membrane", "radius": radius, "stretch": 0.03, "depth": 0.005}
    alone, off = run("predict_force", **press)[1], run("predict_force", **press, radius_sd=sd)[1]
    assert off.value == alone.value
    assert off.sd is not None
    assert alone.sd is not None
    assert off.sd > alone.sd


@pytest.mark.parametrize("name", ["measure_force", "zero_force"])
def test_one_reading_has_no_standard_error(name: str) -> None:
    info = lookup(name)
    assert info is not None
    assert next(port for port in info.of(Role.INPUT) if port.name == "count").min == 2
