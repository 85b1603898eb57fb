"""Presets of the camera: the effects that they name, and the noise and the texture that these leave."""

import numpy as np
import pytest

from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.presets import PRESETS
from stretch_bt.simulation.camera.statistics import deviations_of, texture_of
from stretch_bt.simulation.effects import CameraEffect, registry

EFFECTS = {name: effect for name, effect in registry().items() if issubclass(effect, CameraEffect)}
SHAPE = (333, 213)
FLAT = np.full(SHAPE, 0.2, np.float32)


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
