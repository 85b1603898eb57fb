"""What is true of any input that the strategies beside the cases draw; `make fuzz` draws more of them."""

import math
import zlib
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput, NoEquilibrium, SceneError
from stretch_bt.hardcases.strategies import camera, friction, indenters, membrane, runner, scenes
from stretch_bt.simulation import press
from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.view import SR305
from stretch_bt.simulation.effects.base import Exposure
from stretch_bt.simulation.membrane.sheet.increments import increments
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.scene import parse_scene

COARSE = Settings(coarsen=2.0)


@settings(max_examples=4)
@given(options=membrane.presses())
def test_any_press_ends_in_a_force_with_its_error_or_in_a_reason(options):
    try:
        found = press(**options, settings=COARSE)
    except (NoEquilibrium, InvalidInput) as refused:
        assert len(str(refused)) > 20
        return
    assert found.force > 0
    assert 0 < found.force_error < math.inf
    assert found.balance < 1e-6
    assert found.iterations <= COARSE.budget


@given(start=st.one_of(st.none(), friction.LOADS), load=friction.LOADS)
def test_any_way_is_divided_into_moves_of_a_sheet_unit_and_ends_exactly(start, load):
    loads = list(increments(start, load, 1e-3))
    assert loads[-1] is load
    begun = [start or load.part(0.0), *loads]
    moves = np.abs([(b.moves() - a.moves()) / [1e-3, 1e-3, 1e-3, 1e-3, 0.05, 0.05] for a, b in pairwise(begun)])
    assert moves.max(initial=0.0) <= 1 + 1e-6
    assert len(loads) >= (1 if start else 4)


@settings(max_examples=60)
@given(shape=indenters.SHAPES, seed=st.integers(0, 99))
def test_the_distance_to_any_shape_changes_as_its_normal_says_and_no_faster_than_the_place(shape, seed):
    points = np.random.default_rng(seed).uniform(-0.04, 0.04, (200, 3))
    gap, step = shape.gap(points), 1e-7
    assert np.isfinite(gap.distance).all()
    ahead, behind = (shape.gap(points + s * step * gap.normal).distance for s in (1, -1))
    rises = (ahead - behind) / (2 * step)
    assert (np.abs(rises - 1) < 1e-4).mean() > 0.97  # where two places are nearest the normal jumps
    assert (np.abs(rises) < 1 + 1e-4).all()


def exposed(depth, effect, number):
    lens = SR305.cropped(0, depth.shape[0], 0, depth.shape[1])

    def random(name, k):
        return np.random.default_rng((0, zlib.crc32(name.encode()), k + (1 << 20)))

    exposure = Exposure(np.array(depth, order="C"), lens, number / 30.0, number, 30.0, random, 1e-5)
    effect.expose(exposure)
    return exposure


@settings(max_examples=60)
@given(depth=camera.DEPTHS, effect=camera.effects(), number=st.integers(0, 9000))
def test_no_effect_of_the_camera_gives_depth_where_there_is_none_or_none_that_is_no_number(depth, effect, number):
    seen = exposed(depth, effect, number)
    assert seen.depth.shape == depth.shape
    assert np.isfinite(seen.depth).all()
    assert (seen.depth >= 0).all()
    assert not seen.depth[depth == 0].any()
    assert counts(seen).dtype == np.uint16


@given(text=scenes.TEXTS)
def test_any_scene_is_read_or_refused_with_a_place_and_a_remedy(text):
    try:
        scene = parse_scene(text)
    except SceneError as refused:
        for finding in refused.diagnostics:
            assert finding.message
            assert finding.hint
            assert 1 <= finding.line <= text.count("\n") + 1
        return
    assert 0 < scene.object.top < 2.0
    assert all(math.isfinite(value) for value in scene.object.known().values())


TREE = """\
format: stretch-tree/1
tick: 100 ms
trees:
  main:
    sequence: [{name: first, wait: {duration: 1 s}}, {name: then, timeout: 1 s, wait: {duration: 1 s}}]
    finally: [{name: end, wait: {duration: 1 s}}]
"""


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(ends=st.tuples(runner.ENDS, runner.ENDS, runner.ENDS))
def test_whatever_becomes_of_a_task_what_it_owes_begins(run, ends):
    places = ("main/first", "main/then", "main/finally/end")
    assume(ends[0][0] != "running")
    mocks = [{"match": m, "status": s, "after": f"{ms} ms"} for m, (s, ms) in zip(places, ends, strict=True)]
    result = run(TREE, mocks={"mocks": mocks})
    done = [status == "success" for status, _ in ends]
    assert (result.status == "SUCCESS") == all(done)
    assert bool(result.reason) != all(done)
    assert "main/finally/end" in result.visited


def test_strategies_say_what_they_need(monkeypatch):
    import importlib
    import sys

    from stretch_bt.errors import MissingExtra
    from stretch_bt.hardcases import strategies

    monkeypatch.setitem(sys.modules, "hypothesis", None)
    with pytest.raises(MissingExtra, match=r"pip install 'stretch-bt\[fuzz\]'"):
        importlib.reload(strategies)
