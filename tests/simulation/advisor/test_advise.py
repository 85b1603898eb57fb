"""The advisor's verdicts, over every effect and every shipped scene."""

import math
import subprocess
import sys

import pytest

from stretch_bt.simulation.advisor.advise import advise, switch_on
from stretch_bt.simulation.advisor.choose import choose
from stretch_bt.simulation.effects import registry
from stretch_bt.simulation.objects.registry import kinds
from stretch_bt.simulation.scene import load_scene, parse_scene, scene_names
from stretch_bt.simulation.scene.sections import Tolerance

UNITS = {"height": "m", "size": "m", "force": "", "stiffness": "", "roundness": ""}
SCENES = {name: load_scene(name) for name in scene_names()}
#: every pair of a scene and an effect that it can have
VERDICTS = {(scene, v.name): v for scene in SCENES for v in advise(SCENES[scene]) if v.possible}
#: a scene of each effect, and an effect of each scene
SOME = {*{e: (s, e) for s, e in VERDICTS}.values(), *{s: (s, e) for s, e in VERDICTS}.values()}

pairs = pytest.mark.parametrize(
    ("scene", "effect"), [pair if pair in SOME else pytest.param(*pair, marks=pytest.mark.slow) for pair in VERDICTS]
)

SPHERE = """\
format: stretch-scene/1
object: {type: sphere, diameter: 40 mm, stiffness: 0.9 N/mm}
"""


def verdict(scene, effect):
    return next(v for v in advise(scene) if v.name == effect)


def tolerating(scene, observable, value):
    return scene.with_(tolerance=Tolerance.model_construct(**{observable: value}))


def test_every_effect_has_a_verdict():
    assert [v.name for v in advise(SCENES["water_balloon"])] == list(registry())


def test_each_effect_is_possible_with_some_object():
    able = {effect for kind in kinds().values() for effect in kind.effects}
    others = {v.name for v in advise(parse_scene(f"{SPHERE}effects: all\n")) if v.possible}
    assert able | others == set(registry())


@pytest.mark.parametrize(("scene", "effect"), VERDICTS)
def test_sizes_are_finite_and_in_the_unit_of_their_tolerance(scene, effect):
    found = VERDICTS[scene, effect]
    assert found.why
    assert math.isfinite(found.cost_ms)
    assert found.cost_ms >= 0
    assert (found.observable is None) == (found.estimate is None) == (found.threshold is None)
    if found.observable is not None:
        assert math.isfinite(found.estimate)
        assert found.estimate >= 0
        assert found.unit == UNITS[found.observable]
        tolerance = SCENES[scene].tolerance.named()[found.observable]
        assert found.threshold == pytest.approx(registry()[effect].worth * tolerance)


@pairs
def test_a_name_switches_on_and_off_whatever_the_size(scene, effect):
    for word, on in (("on", True), ("off", False)):
        chosen = SCENES[scene].with_(effects=type("Effects", (), dict.fromkeys(registry(), "auto") | {effect: word}))
        found = verdict(chosen, effect)
        assert found.on is on
        assert f"the scene says {word}" in found.why
        assert not found.near


@pairs
def test_auto_goes_by_each_tolerance(scene, effect):
    """For each result: an effect is on when its change alone is more than its share of the tolerance, and near where both are close."""
    needed = registry()[effect].needs
    choices = dict.fromkeys(registry(), "auto") | ({needed: "on"} if needed else {})
    left = SCENES[scene].with_(effects=type("Effects", (), choices))
    for observable in UNITS:
        size = verdict(tolerating(left, observable, 1e-9), effect).estimate
        if not size:
            strict = tolerating(left, observable, 1e-9)
            assert not verdict(strict, effect).on or effect in choose(strict).together
            continue
        for part, on, near in ((0.99, True, True), (1.01, False, True), (0.32, True, False), (3.1, False, False)):
            asked = tolerating(left, observable, part * size / registry()[effect].worth)
            found = verdict(asked, effect)
            assert (found.observable, found.estimate) == (observable, pytest.approx(size))
            assert (found.on, found.near) == (on or effect in choose(asked).together, near)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize(("word", "on"), [("all", True), ("none", False)])
def test_one_word_for_all(scene, word, on):
    for found in advise(SCENES[scene].with_(effects=word)):
        assert found.on is (on and found.possible), found


def test_only_what_is_on_is_made():
    scene = parse_scene(f"{SPHERE}effects: {{sag: on, compliance: off, white_noise: {{sd: 0.3 mm}}}}\n")
    made = switch_on(scene)
    assert {effect.name for effect in made} == {v.name for v in advise(scene) if v.on}
    assert "sag" in made
    assert "compliance" not in made
    assert made.get("white_noise").parameters.sd == pytest.approx(3e-4)
    order = [effect.name for effect in made]
    assert order == [name for name in registry() if name in order]


def test_advice_loads_nothing_heavy():
    script = (
        "import sys\n"
        "from stretch_bt.simulation.scene import load_scene, scene_names\n"
        "from stretch_bt.simulation.advisor.advise import advise\n"
        "[advise(load_scene(name)) for name in scene_names()]\n"
        "print(*{m.partition('.')[0] for m in sys.modules} & {'numba', 'scipy', 'cv2', 'trimesh'})\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
