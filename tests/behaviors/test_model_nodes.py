"""Nodes that compute: what they write carries its error, and what has no answer is a FAILURE with its reason."""

from functools import partial
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.behaviors._readings import Reading, readings_of
from stretch_bt.run.context import RunContext
from stretch_bt.tree.ports import MISSING, Behavior, Cell, Role, Status
from stretch_bt.tree.registry import lookup

radii = st.floats(0.006, 0.040)
stretches = st.floats(0.0, 0.060)
depths = st.floats(0.004, 0.014)


def run(name: str, **inputs: Any) -> tuple[Behavior, Cell]:
    info = lookup(name)
    assert info is not None
    node = info.cls(f"main/{name}")
    node.context = RunContext()
    for port in info.of(Role.INPUT):
        node.wiring[port.name] = partial(inputs.get, port.name, port.default)
    for _ in node.tick():
        pass
    return node, next(iter(node.sinks.values()))


@given(radius=radii, stretch=stretches, depth=depths)
def test_the_next_indentation_gives_the_same_force(radius: float, stretch: float, depth: float) -> None:
    _, force = run("predict_force", radius=radius, stretch=stretch, depth=depth)
    node, start = run("next_indentation", radius=radius, stretch=stretch, force=force.value)
    assert node.status is Status.SUCCESS
    assert start.value == pytest.approx(depth, rel=1e-6)
    _, harder = run("next_indentation", radius=radius, stretch=stretch + 0.02, force=force.value)
    assert harder.value < depth, "a tenser membrane needs less depth"


@given(radius=radii, stretch=stretches, depth=depths)
def test_the_chosen_stretch_gives_the_wanted_force(radius: float, stretch: float, depth: float) -> None:
    _, force = run("predict_force", radius=radius, stretch=stretch, depth=depth)
    node, found = run("choose_stretch", radius=radius, depth=depth, force=force.value)
    assert node.status is Status.SUCCESS
    assert found.value == pytest.approx(stretch, abs=1e-6)
    assert found.sd is not None
    assert found.sd >= 0


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
        ("choose_stretch", {"radius": 0.01, "depth": 0.005, "force": 100.0}),
    ],
)
def test_what_has_no_answer_fails_with_its_reason_and_writes_nothing(name: str, inputs: dict[str, float]) -> None:
    node, written = run(name, **inputs)
    assert node.status is Status.FAILURE
    assert len(node.reason) > 20
    assert written.value is MISSING


def test_stiffness_is_the_force_over_what_was_lost() -> None:
    node, stiffness = run("estimate_stiffness", force=1.5, deflection=0.0015, force_sd=0.03, deflection_sd=0.00003)
    assert (node.status, stiffness.value) == (Status.SUCCESS, pytest.approx(1000.0))
    assert stiffness.sd == pytest.approx(1000 * (0.02**2 + 0.02**2) ** 0.5, rel=1e-6)


def followed(readings: list[tuple[float, float, float]], approached: bool) -> Behavior:
    """Return `track_drop` after it ran at each reading (membrane depth, height, sd), m, with or without an approach."""
    info = lookup("track_drop")
    assert info is not None
    node = info.cls("main/track_drop")
    node.context = RunContext()
    if approached:
        readings_of(node.context).append(Reading(0.0, 0.002, 0.0598, 2e-5))
    for depth, height, sd in readings:
        inputs = {
            "radius": 0.03,
            "stretch": 0.0,
            "depth": depth,
            "height": height,
            "height_sd": sd,
            "contact_height": 0.06,
        }
        for port in info.of(Role.INPUT):
            node.wiring[port.name] = partial(inputs.get, port.name, port.default)
        for _ in node.tick():
            pass
    return node


def test_a_drop_is_read_off_all_presses_together() -> None:
    # A spring under a force that grows as depth^1.5: 0.2 mm at 2 mm of depth.
    noise = [3e-5, -6e-5, 5e-5, -2e-5, 4e-5, -8e-5]
    exact = [0.06 - 0.2e-3 * (d / 2.0) ** 1.5 for d in range(3, 9)]
    readings = [(d * 1e-3, h + e, 5e-5) for d, h, e in zip(range(3, 9), exact, noise, strict=True)]
    node = followed(readings, approached=True)
    assert node.status is Status.SUCCESS
    drop, settled = node.sinks["drop"], node.sinks["settled"]
    assert drop.value == pytest.approx(1.6e-3, abs=0.1e-3)
    assert drop.sd is not None
    assert drop.sd < 0.15e-3
    assert abs(settled.value - exact[-1]) < abs(noise[-1]), "the curve evens out the noise of the last reading"


def test_without_an_approach_a_drop_is_counted_from_the_contact_height() -> None:
    node = followed([(0.008, 0.0584, 5e-5)], approached=False)
    assert node.sinks["drop"].value == pytest.approx(1.6e-3)
    assert node.sinks["drop"].sd == pytest.approx(5e-5)
    assert node.sinks["top"].value == 0.06
