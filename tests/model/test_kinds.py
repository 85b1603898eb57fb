"""What is no number, estimate or model at all: each public function refuses each of its arguments, or gives an answer."""

import inspect

import numpy as np
import pytest

from stretch_bt import model
from stretch_bt.errors import IllConditioned, InvalidInput, NoAnswer, StretchError
from stretch_bt.model.force.force_model import SHIPPED, shipped
from stretch_bt.units import Estimate

ODD = {
    "None": None,
    "text": "10mm",
    "bytes": b"10",
    "a number": 7,
    "a fraction": 0.01,
    "NaN": np.nan,
    "a truth": True,
    "a list of nothing": [],
    "a list of None": [None, 1],
    "a mapping": {},
    "objects": np.array([[None, "x"], [1, 2]], dtype=object),
    "no number": np.array(0.02),
    "numbers": np.array([0.01, 0.02]),
    "two axes": np.ones((2, 3)),
    "complex": 1j,
    "an estimate": Estimate(0.01, 1e-3),
    "an estimate of NaN": Estimate(0.01, np.nan),
    "another object": object(),
}
PLACES = {"radius": 0.01, "stretch": 0.03, "depth": 0.008}
MODELS = {name: shipped(name) for name in SHIPPED}
LAW = MODELS["paper"]
READINGS = [model.TopReading(0.03, 0.10 - 0.002 * k, 0.105 - 0.0002 * k, 1e-5) for k in range(4)]
RADIUS = Estimate(0.02, 1e-4)
FIT = model.fit_series(LAW, RADIUS, READINGS)
PRESS = {
    "model": LAW, "radius": 0.02, "fit": FIT, "last": READINGS[-1], "drop": 2e-3,
    "limits": model.Limits(lowest=0.09, force=5.0, stretch=0.04, stretch_step=0.005),
}  # fmt: skip


def methods():
    for name, law in MODELS.items():
        yield f"{name} predict", law.predict, PLACES
        yield f"{name} depth_for", law.depth_for, {"radius": 0.01, "stretch": 0.03, "force": 0.5}
        yield f"{name} stretch_for", law.stretch_for, {"radius": 0.01, "depth": 0.008, "force": 0.5}
        yield f"{name} in_range", law.in_range, PLACES
        yield f"{name} deepest", law.deepest, {"radius": 0.01, "stretch": 0.03}
        yield f"{name} hang", law.hang, {"stretch": 0.03}


def functions():
    far = Estimate(0.8, 0.01), Estimate(3e-3, 1e-4)
    yield "estimate_stiffness", model.estimate_stiffness, {"force": far[0], "deflection": far[1], "together": 0.0}
    sphere = {"force": far[0], "deflection": far[1], "depth": far[1], "radius": RADIUS, "poisson": 0.5}
    yield "object_modulus", model.object_modulus, sphere
    yield (
        "cube_yield_stress",
        model.cube_yield_stress,
        {"force": far[0], "edge": RADIUS, "height": Estimate(0.018, 1e-4), "density": 1250.0},
    )
    yield "drop_power", model.drop_power, {"strain": Estimate(0.3, 0.05), "power": model.POWER}
    heights = {"depths": [1e-3, 2e-3, 3e-3], "heights": [0.1, 0.0999, 0.0997], "sds": [1e-4] * 3, "power": model.POWER}
    yield "undeformed_height", model.undeformed_height, heights
    options = {"top": None, "power": model.POWER, "stiffening": model.STIFFENING, "robot_sd": 5e-5, "common_sd": 0.0}
    yield "fit_series", model.fit_series, {"model": LAW, "radius": RADIUS, "readings": READINGS, **options}
    yield "next_indentation", model.next_indentation, {"model": LAW, "radius": 0.01, "stretch": 0.03, "force": 0.5}
    yield "next_press", model.next_press, {**PRESS, "needed": None}
    looks = {"looks": model.Looks(1e-4, 1e-5, 5e-5), "costs": model.Costs(), "counts": (8, 16), "least": 0.01}
    yield "next_look", model.next_look, {**PRESS, **looks}
    ball = {"shape": "sphere", "modulus": 6e4, "radius": 0.01, "angle": None, "poisson": 0.5, "object_modulus": np.inf}
    yield "hertz_force", model.hertz_force, {**ball, "depth": 1e-3, "object_poisson": 0.5}
    yield "hertz_depth", model.hertz_depth, {**ball, "force": 0.1, "object_poisson": 0.5}
    yield "calibrate", model.calibrate, {"given": None, "model": "paper"}
    yield "read_table", model.read_table, {"path": "no table"}
    yield "load", model.ForceModel.load, {"path": "no file"}
    yield "Costs", model.Costs, {"speed": 0.005, "change": 3.5, "frame": 0.03, "settle": 0.0}
    yield "Looks", model.Looks, {"frame": 1e-4, "fixed": 1e-5, "robot": 5e-5, "taken": 0.0}
    yield "Limits", model.Limits, {"lowest": 0.09, "force": 5.0, "stretch": 0.04, "stretch_step": 0.005}
    for name in ("stiffness_at", "force_at"):
        yield f"Series.{name}", getattr(FIT, name), {"drop": 1e-3}
    for name in ("drop_at", "height_at"):
        yield f"Series.{name}", getattr(FIT, name), {"force": 0.5}


CALLS = {name: (call, these) for name, call, these in (*methods(), *functions())}
PAIRS = [(name, parameter) for name, (_, these) in CALLS.items() for parameter in these]


@pytest.mark.parametrize("name", [name for name in CALLS if name not in ("calibrate", "read_table", "load")])
def test_the_table_calls_each_function_as_it_is_meant(name):
    call, these = CALLS[name]
    assert set(these) <= set(inspect.signature(call).parameters)
    try:
        call(**these)
    except NoAnswer:
        assert name in ("paper stretch_for", "membrane stretch_for", "sheet stretch_for")


@pytest.mark.parametrize(("name", "parameter"), PAIRS)
def test_an_argument_of_another_kind_is_refused_as_such(name, parameter):
    call, these = CALLS[name]
    wrong = []
    for odd, value in ODD.items():
        try:
            call(**these | {parameter: value})
        except StretchError as error:
            assert str(error)
        except Exception as error:
            wrong.append(f"{odd}: {type(error).__name__}: {error}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda: model.estimate_stiffness(0.8, 0.003), InvalidInput, r"force is an Estimate.*not 0\.8; write Estimate"),
        (lambda: model.fit_series(LAW, RADIUS, []), IllConditioned, "no reading of the object's top.*; press at two"),
        (lambda: model.undeformed_height([], [], []), IllConditioned, "there is no reading of the top.*; press at two"),
        (lambda: LAW.predict("10mm", 0.03, 0.008), InvalidInput, "radius is a finite number, in m, not '10mm'"),
    ],
)
def test_a_refusal_names_the_argument_and_what_to_give(call, kind, said):
    with pytest.raises(kind, match=said):
        call()
