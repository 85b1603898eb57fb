"""An effect that is off is neither constructed nor called, in any shipped scene; one that is on is."""

import inspect
from collections import Counter

import pytest

from stretch_bt.frames import Pose
from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.effects import Active, Effect, registry
from stretch_bt.simulation.scene import load_scene, scene_names

SPEED = 0.1  # m/s
#: scenes that have on what another one has on
ALIKE = {
    *("calibration_cone", "calibration_cylinder", "paper_pyramid", "wire_circle", "wire_triangle"),
    *("air_balloon", "seeds_balloon", "pudding_balloon", "wooden_cube", "paper_cube", "paper_half_cylinder"),
    *("wooden_bridge", "wooden_half_cylinder", "wooden_prism"),
}


def hooks(effect):
    """Return the names of all methods of an effect that can be called once it is made, its group's included."""
    groups = [c for c in effect.__mro__ if issubclass(c, Effect)]
    names = {name for c in groups for name, member in vars(c).items() if inspect.isfunction(member)}
    return sorted(name for name in names if not name.startswith("__"))


def forbidden(effect, hook):
    def refuse(*_, **__):
        raise AssertionError(f"{effect.name} is off, and its {hook} is called")

    return refuse


def counting(name, method, calls):
    def counted(self, *arguments):
        calls[name] += 1
        return method(self, *arguments)

    return counted


@pytest.fixture
def watched(monkeypatch):
    """Break every effect that is off in a scene, count the calls of the others, and return the counts and the others' names."""

    def watch(scene):
        calls = Counter()
        on = {verdict.name for verdict in advise(scene) if verdict.on}
        for name, effect in registry().items():
            if name not in on:
                for hook in ("__init__", *hooks(effect)):
                    monkeypatch.setattr(effect, hook, forbidden(effect, hook))
                continue
            for hook, method in [(h, m) for h, m in vars(effect).items() if h in hooks(effect)]:
                monkeypatch.setattr(effect, hook, counting(name, method, calls))
        look_up = Active.get
        known = Active.__contains__
        monkeypatch.setattr(Active, "get", lambda self, name: calls.update([name]) or look_up(self, name))
        monkeypatch.setattr(Active, "__contains__", lambda self, name: calls.update([name]) or known(self, name))
        return calls, on

    return watch


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name in ALIKE else []) for name in scene_names()]
)
def test_what_is_off_is_never_touched(name, watched, make_cell, clock, advance):
    scene = load_scene(name)
    calls, on = watched(scene)
    press(make_cell(scene=name), scene, clock, advance)
    assert {effect for effect in on if not calls[effect]} == set()


def press(cell, scene, clock, advance):
    """Press an object twice, and look and feel while the hand goes down, holds and goes up."""
    arm, gripper, camera, sensor = (cell.devices[n] for n in ("arm", "gripper", "camera", "force_sensor"))
    place, top = scene.object.position, scene.object.top
    depth = min(0.3 * scene.conditions.depth, 0.003)
    advance(gripper.move(cell.hand.geometry.opening(scene.conditions.stretch), speed=SPEED, owner="test"))
    felt = []
    for height in (top + 0.01, top - depth, top + 0.001, top - depth, top + 0.01):
        advance(arm.move(Pose((place.x, place.y, height)), speed=SPEED, owner="test"))
        clock.time += 0.1
        assert camera.frame(1.0).value.raw.any()
        felt.append(sensor.wrench(1.0).value.force[2])
        arm.wrench(1.0)
    assert max(felt[1], felt[3]) > max(felt[0], felt[4])
