"""What an effect says is left of it, against least squares on frames with it."""

import numpy as np
import pytest

from stretch_bt.errors import FileError
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.presets import PRESETS
from stretch_bt.simulation.camera.view import SR305
from stretch_bt.simulation.effects import CameraEffect, registry
from stretch_bt.simulation.effects.base import Exposure
from stretch_bt.simulation.scene.file import parse_scene

EFFECTS = {name: effect for name, effect in registry().items() if issubclass(effect, CameraEffect)}
SCENE = """
format: stretch-scene/1
object: {object}
conditions: {{stretch: 30 mm, depth: {depth}, frames: {frames}}}
camera: {camera}
"""
NOISES = ("white_noise", "correlated_noise", "fixed_pattern")
ROUND = "{type: sphere, diameter: 50 mm, rigid: true}"
FLAT = "{type: cylinder, diameter: 20 mm, height: 40 mm, rigid: true}"


def case_of(thing, camera="bench", frames=4, depth="10 mm"):
    scene = parse_scene(SCENE.format(object=thing, camera=camera, frames=frames, depth=depth))
    return Case(scene, scene.object.rough())


def sizes(name, case):
    effect = EFFECTS[name]
    found = {}
    for size in effect.sizes(case, case.scene.parameters(effect)):
        found[size.observable] = max(size.value, found.get(size.observable, 0.0))
    return found


def designs(case):
    """Return the places of a contact's pixels in the image and the designs that give height and mean curvature there."""
    curved = case.rough.edge >= case.radius / 2
    radius = case.contact_radius if curved else case.radius
    v, u = np.mgrid[0:333, 0:213]
    y, x = (v - 166) * case.pixel, (u - 106) * case.pixel
    inside = np.hypot(x, y) < radius
    x, y = x[inside] / radius, y[inside] / radius
    one = np.ones_like(x)
    free = np.stack([one, x, y, x * x, x * y, y * y] if curved else [one], axis=1)
    even = np.stack([one, x, y, 0.5 * (x * x + y * y)], axis=1)
    return inside, np.linalg.pinv(free)[0], np.linalg.pinv(even)[3] / radius**2


@pytest.mark.parametrize("thing", [ROUND, pytest.param(FLAT, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("camera", "name"), [(c, n) for c in PRESETS for n in PRESETS[c] if n in NOISES])
def test_estimates_are_right_within_a_factor_of_two(name, camera, thing, expose):
    case = case_of(thing, camera)
    inside, top, bend = designs(case)
    heights, bends = [], []
    for seed in range(60):
        effect = EFFECTS[name](PRESETS[camera][name])
        frames = range(1 if name == "fixed_pattern" else case.frames)
        off = np.mean(
            [expose(np.full((333, 213), 0.2), [effect], number=k, seed=seed).depth[inside] for k in frames], axis=0
        )
        off = off.astype(float) - 0.2
        heights.append(top @ off)
        bends.append(bend @ off)
    said = sizes(name, case)
    assert 0.5 < said["height"] / np.std(heights) < 2
    if thing == ROUND:
        assert 0.5 < said["size"] / min(np.std(bends) * case.radius**2, case.radius) < 2


def test_rounding_matters_on_a_flat_face_that_nothing_dithers(expose):
    """The height of a flat face, over faces at all heights between two counts."""
    quiet = case_of(FLAT).scene.with_(effects="none")
    case = Case(quiet, quiet.object.rough())
    effect = EFFECTS["quantisation"]
    said = max(s.value for s in effect.sizes(case, effect.Parameters()) if s.observable == "height")
    off = np.linspace(0, 0.125e-3, 500, endpoint=False)
    rounded = np.rint((0.19 + off) / 0.125e-3) * 0.125e-3 - 0.19 - off
    assert said == pytest.approx(rounded.std(), rel=0.02)
    assert sizes("quantisation", case_of(FLAT))["height"] < 0.05 * said


def test_a_lens_makes_a_contact_wider_by_what_it_says():
    from stretch_bt.perception.deprojection import ray_table
    from stretch_bt.simulation.camera.view import SR305

    case = case_of("{type: cylinder, diameter: 60 mm, height: 40 mm, rigid: true}")
    effect = EFFECTS["lens_distortion"]
    rays = ray_table(effect(effect.Parameters()).lens(SR305))[240]
    told = (np.arange(640) - SR305.cx) / SR305.fx  # where perception thinks that its pixels look
    ends = np.interp([-0.15, 0.15], rays[:, 0], told)  # of a face 60 mm wide at 200 mm
    assert sizes("lens_distortion", case)["size"] == pytest.approx(abs(np.ptp(ends) - 0.3) * 0.2, rel=0.3)


def test_what_is_stronger_never_counts_less():
    case = case_of(ROUND)
    for name, field in (("white_noise", "sd"), ("correlated_noise", "sd"), ("fixed_pattern", "sd"), ("drift", "rate")):
        effect = EFFECTS[name]
        unit = "mm/s" if field == "rate" else "mm"
        said = [
            [s.value for s in effect.sizes(case, effect.Parameters.model_validate({field: f"{value} {unit}"}))]
            for value in (0, 0.001, 0.01, 0.1, 0.9)
        ]
        assert np.all(np.diff(said, axis=0) >= 0)
        assert not np.any(said[0])


def test_the_least_count_reaches_past_the_membrane():
    """Counts of 16 bits of less than 3 um ended before the membrane, and every pixel was empty."""
    text = "format: stretch-scene/1\nobject: {type: plane, height: 40 mm, rigid: true}\nfidelity: hertz\neffects: {quantisation: {unit: 0.00%d mm}}\n"
    unit = parse_scene(text % 5).parameters(EFFECTS["quantisation"]).unit
    exposure = Exposure(np.full((1, 1), 0.3, np.float32), SR305, 0.0, 0, 30.0, np.random.default_rng, unit)
    assert counts(exposure)[0, 0] == 60000
    with pytest.raises(FileError, match="unit"):
        parse_scene(text % 4)
