"""Each effect of the camera: what it asks for is what is measured, the same seed gives the same, and extremes do no harm."""

import math

import numpy as np
import pytest

from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.presets import PRESETS
from stretch_bt.simulation.camera.statistics import deviations_of, texture_of
from stretch_bt.simulation.effects import CameraEffect, registry
from stretch_bt.simulation.effects.correlated_noise import CorrelatedNoise
from stretch_bt.simulation.effects.drift import Drift
from stretch_bt.simulation.effects.dropout import Dropout
from stretch_bt.simulation.effects.fixed_pattern import FixedPattern
from stretch_bt.simulation.effects.flying_pixels import FlyingPixels
from stretch_bt.simulation.effects.quantisation import Quantisation
from stretch_bt.simulation.effects.white_noise import WhiteNoise

EFFECTS = {name: effect for name, effect in registry().items() if issubclass(effect, CameraEffect)}
SHAPE = (333, 213)
FLAT = np.full(SHAPE, 0.2, np.float32)


def made(effect, **parameters):
    return effect(effect.Parameters.model_validate(parameters))


def noise(**parameters):
    return made(CorrelatedNoise, **parameters)


def gauss(kernel):
    return [math.exp(-(k**2) / (4 * kernel**2)) for k in (1, 2, 3)]


#: effect; and of 40 frames: sd, mm, correlation of pixels 1, 2, 3 apart, of frames, sd of the mean over frames, mm, share lost
ASKED = {
    "white, 0.05 mm": (made(WhiteNoise, sd="0.05 mm"), 0.05, [0, 0, 0], 0, 0.05 / 40**0.5, 0),
    "white, 5 mm": (made(WhiteNoise, sd="5 mm"), 5, [0, 0, 0], 0, 5 / 40**0.5, 0),
    "white, told for 100 mm": (made(WhiteNoise, sd="0.1 mm", reference_depth="100 mm"), 0.4, [0, 0, 0], 0, 0.4 / 40**0.5, 0),
    "correlated, 3 px, memory 0.6": (noise(), 0.3, gauss(3), 0.6, None, 0),
    "correlated, 1.5 px, no memory": (noise(sd="1 mm", kernel=1.5, memory=0.0), 1, gauss(1.5), 0, 1 / 40**0.5, 0),
    "correlated, 1 px, memory 0.9": (noise(kernel=1.0, memory=0.9), 0.3, gauss(1), 0.9, None, 0),
    "correlated, 0 px": (noise(kernel=0.0, memory=0.3), 0.3, [0, 0, 0], 0.3, None, 0),
    "dropout, 1 %": (made(Dropout), 0, [0, 0, 0], 0, 0, 0.01),
    "dropout, 30 %": (made(Dropout, share=0.3), 0, [0, 0, 0], 0, 0, 0.3),
    "dropout, all": (made(Dropout, share=1.0), 0, [0, 0, 0], 0, 0, 1),
}  # fmt: skip


@pytest.mark.parametrize("name", ASKED)
def test_what_is_asked_for_is_what_is_measured(name, expose):
    effect, sd, beside, after, fixed, lost = ASKED[name]
    found = deviations_of([expose(FLAT, [effect], number=n).depth for n in range(40)], FLAT)
    assert found.sd * 1e3 == pytest.approx(sd, rel=0.03)
    assert found.beside == pytest.approx(beside, abs=0.02)
    assert found.after == pytest.approx(after, abs=0.02)
    assert fixed is None or found.fixed * 1e3 == pytest.approx(fixed, rel=0.05, abs=1e-9)
    assert found.lost == pytest.approx(lost, rel=0.03)


def test_the_memory_of_correlated_noise_fades_as_a_power(expose):
    effect = noise(memory=0.7)
    stack = np.stack([expose(FLAT, [effect], number=n).depth for n in range(60)]).astype(float) - 0.2
    found = [(stack[k:] * stack[:-k]).mean() / (stack**2).mean() for k in (1, 2, 3, 5)]
    assert found == pytest.approx([0.7**k for k in (1, 2, 3, 5)], abs=0.03)


def test_a_fixed_pattern_stays_and_differs_between_runs(expose):
    effect = made(FixedPattern)
    runs = [[expose(FLAT, [effect], number=n, seed=s).depth - FLAT for n in (0, 7)] for s in range(60)]
    assert all(np.array_equal(first, later) for first, later in runs)
    fields = np.stack([first for first, _ in runs]).astype(float)
    assert fields.std() * 1e3 == pytest.approx(0.5, rel=0.06)
    aside = (fields[:, :, 40:] * fields[:, :, :-40]).mean() / (fields**2).mean()
    assert aside == pytest.approx(math.exp(-1 / 4), abs=0.08)


def test_drift_grows_evenly_and_takes_either_sign(expose):
    effect = made(Drift, rate="0.2 mm/min")
    moved = [
        [float((expose(FLAT, [effect], number=30 * t, seed=s).depth - FLAT).mean()) for t in (0, 30, 60)]
        for s in range(20)
    ]
    assert np.allclose(np.abs(moved), [[0, 0.1e-3, 0.2e-3]] * 20, atol=1e-7)
    assert {float(np.sign(end)) for *_, end in moved} == {-1.0, 1.0}


@pytest.mark.parametrize(
    ("slope", "times"), [(0.0, 1.0), (math.tan(math.radians(57)), 1.0), (math.tan(math.radians(63)), 10.0)]
)
@pytest.mark.parametrize("turn", [0, 1])
def test_dropout_is_ten_times_as_likely_on_steep_ground(slope, times, turn, expose, crop):
    """A plane z = d + slope x through the optical axis has the depth d / (1 - slope (u - cx) / fx)."""
    lens = crop.cropped(160, 172, 100, 112)  # so close to the axis that the sight is along it
    across = ((np.arange(12) - lens.cx) / lens.fx, (np.arange(12) - lens.cy) / lens.fy)[turn]
    line = 0.2 / (1 - slope * across)
    depth = np.broadcast_to(line if turn == 0 else line[:, None], (12, 12)).astype(np.float32)
    lost = np.mean([expose(depth, [made(Dropout)], number=n, lens=lens).depth == 0 for n in range(1500)])
    assert lost == pytest.approx(0.01 * times, rel=0.08)


def test_pixels_fly_at_edges_only_and_towards_the_other_side(expose, crop):
    depth = np.full(SHAPE, 0.2, np.float32)
    depth[:, 100:] = 0.2045  # under the step that makes an edge
    depth[200:] += np.float32(0.007)
    depth[:, 150:] = 0.0
    effect = made(FlyingPixels, share=0.2)
    moved = np.stack([expose(depth, [effect], number=n).depth - depth for n in range(40)])
    assert set(np.flatnonzero(moved.any(axis=(0, 2)))) == {199, 200}
    assert not moved[:, :, 150:].any()
    assert (moved[:, 199:201, :150] != 0).mean() == pytest.approx(0.2, rel=0.05)
    assert moved[:, 199].min() >= 0
    assert moved[:, 200].max() <= 0
    far = np.abs(moved[moved != 0])
    assert far.min() >= 2e-3 - 1e-7
    assert far.max() <= 7e-3 + 1e-7


def test_an_edge_with_a_step_of_depth_flies_at_most_ten_millimetres(expose):
    depth = np.full(SHAPE, 0.2, np.float32)
    depth[:, 100:] = 0.25
    moved = np.abs(expose(depth, [made(FlyingPixels, share=1.0)]).depth - depth)
    assert np.all(moved[:, 99:101] > 0)
    assert np.mean(moved[:, 99:101]) == pytest.approx(6e-3, rel=0.05)
    assert moved.max() <= 0.01 + 1e-7


def test_counts_are_those_of_the_quantisation_and_what_does_not_fit_is_no_value(expose, crop):
    depth = np.array([[0.0, 0.2, 0.20006, 8.19, 9.0, 1e-9]], np.float32)
    lens = crop.cropped(0, 1, 0, 6)
    assert counts(expose(depth, [made(Quantisation)], lens=lens)).tolist() == [[0, 1600, 1600, 65520, 0, 0]]
    assert counts(expose(depth, [], lens=lens)).tolist() == [[0, 20000, 20006, 0, 0, 0]]


@pytest.mark.parametrize("name", [n for n in EFFECTS if n not in ("quantisation", "lens_distortion")])
def test_one_seed_gives_one_frame_whatever_was_asked_before(name, expose):
    depth = np.full(SHAPE, 0.2, np.float32)
    depth[:, 100:] = 0.25
    effect = EFFECTS[name]
    parameters = effect.Parameters.model_validate({"share": 0.3} if name == "flying_pixels" else {})
    straight, back, fresh = effect(parameters), effect(parameters), None
    forward = [expose(depth, [straight], number=n, seed=3).depth for n in range(12)]
    for n in (11, 4, 9, 0):
        expose(depth, [back], number=n + 1, seed=8)  # another run of the same effect in between
        fresh = effect(parameters)
        for other in (back, fresh):
            assert np.array_equal(expose(depth, [other], number=n, seed=3).depth, forward[n])
    assert not np.array_equal(expose(depth, [fresh], number=9, seed=4).depth, forward[9]) or name == "drift"


@pytest.mark.parametrize("name", EFFECTS)
@pytest.mark.parametrize("shape", [(0, 0), (0, 30), (1, 1), (3, 40)])
def test_small_and_empty_images_pass(name, shape, expose, crop):
    lens = crop.cropped(0, shape[0], 0, shape[1])
    effect = EFFECTS[name](EFFECTS[name].Parameters())
    assert counts(expose(np.full(shape, 0.2), [effect], lens=lens)).shape == shape


@pytest.mark.parametrize("name", EFFECTS)
def test_no_effect_gives_a_value_where_there_is_none_or_a_negative_one(name, expose):
    depth = np.full(SHAPE, 0.004, np.float32)
    depth[50:100] = 0.0
    sizes = {"sd": "50 mm"} if "sd" in EFFECTS[name].Parameters.model_fields else {}
    seen = expose(depth, [made(EFFECTS[name], **sizes)], number=9000).depth
    assert not seen[50:100].any()
    assert np.isfinite(seen).all()
    assert (seen >= 0).all()


@pytest.mark.parametrize(
    "name", ["white_noise", "correlated_noise", "fixed_pattern", "dropout", "flying_pixels", "drift"]
)
def test_nothing_asked_for_is_nothing_done(name, expose):
    fields = EFFECTS[name].Parameters.model_fields
    nothing = {f: v for f, v in {"sd": "0 mm", "share": 0.0, "rate": "0 mm/s"}.items() if f in fields}
    depth = np.full(SHAPE, 0.2, np.float32)
    depth[:, 100:] = 0.25
    assert np.array_equal(expose(depth, [made(EFFECTS[name], **nothing)], number=500).depth, depth)


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_names_effects_that_there_are_with_their_own_parameters(preset):
    for name, parameters in PRESETS[preset].items():
        assert isinstance(parameters, EFFECTS[name].Parameters)


def test_hard_has_the_papers_millimetre(expose):
    effects = [EFFECTS[name](p) for name, p in PRESETS["hard"].items() if name != "fixed_pattern"]
    effects.sort(key=lambda e: e.order)
    found = deviations_of([expose(FLAT, effects, number=n).depth for n in range(30)], FLAT)
    assert found.sd == pytest.approx(1e-3, rel=0.03)


def test_the_texture_of_the_preset_is_that_of_a_real_camera(data, expose):
    """The same code on real frames and on planes at their depths, through the preset's effects and counts."""
    from stretch_bt.frames import DepthFrame, Intrinsics
    from stretch_bt.perception import load_depth_png

    lens = Intrinsics(476.007, 476.007, 313.683, 242.755, 640, 480)
    real = texture_of(load_depth_png(p, unit=0.125e-3, intrinsics=lens) for p in sorted((data / "sr305").glob("*.png")))

    def frame(number, depth):
        plane = np.broadcast_to(depth + np.linspace(0, 3e-3, 640), (480, 640))
        effects = [EFFECTS[name](p) for name, p in PRESETS["sr305_texture"].items()]
        seen = expose(plane, sorted(effects, key=lambda e: e.order), number=number, lens=lens)
        return DepthFrame(counts(seen), seen.unit, lens, 0.0, number)

    made_up = texture_of(frame(k, z) for k, z in enumerate((0.55, 0.67, 0.75, 0.83)))
    assert made_up.growth == pytest.approx(real.growth, rel=0.1)
    assert made_up.beside == pytest.approx(real.beside, abs=0.1)
