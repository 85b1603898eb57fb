import math
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.effects.compliance import Compliance
from stretch_bt.simulation.effects.rigid_shift import RigidShift
from stretch_bt.simulation.effects.roof_sag import RoofSag
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.scene import parse_scene

LENGTHS = st.floats(-0.02, 0.02)


def shift(membrane=0.5, table=0.3):
    return RigidShift(RigidShift.Parameters.model_validate({"membrane": membrane, "table": table}))


def press(across=(0.0, 0.0), force=1.0, sideways=(0.0, 0.0), depth=0.01):
    return Moved(0.0, (*sideways, -force), across, 0.1, depth)


def scene(thing, travel="0 mm"):
    return parse_scene(f"format: stretch-scene/1\nobject: {thing}\nconditions: {{travel: {travel}}}\n")


RING = "{type: wire_circle, diameter: 50 mm, position: {x: 3 mm, y: -2 mm}}"


@given(x=LENGTHS, y=LENGTHS, weight=st.floats(0, 0.5))
def test_the_pull_stays_within_what_the_table_holds(x, y, weight):
    slip, strain = shift(membrane=10.0).slide((0.0, 0.0), press((x, y)), weight)
    pull = 1.0 / 0.01 * math.hypot(*strain)
    assert pull <= 0.3 * (1.0 + weight) * (1 + 1e-9)
    assert slip[0] + strain[0] == pytest.approx(x, abs=1e-12)
    assert slip[1] + strain[1] == pytest.approx(y, abs=1e-12)
    assert (slip == (0.0, 0.0)) == (100 * math.hypot(x, y) <= 0.3 * (1.0 + weight) * (1 + 1e-12)) or math.hypot(
        *slip
    ) < 1e-9


@given(x=st.floats(0, 0.03), parts=st.integers(2, 5))
def test_a_straight_path_in_parts_ends_where_the_whole_does(x, parts):
    effect, place, strain = shift(), 0.0, (0.0, 0.0)
    for _ in range(parts):
        slip, strain = effect.slide(strain, press((x / parts, 0.0)), 0.02)
        place += slip[0]
    whole, _ = effect.slide((0.0, 0.0), press((x, 0.0)), 0.02)
    assert place == pytest.approx(whole[0], abs=1e-12)


def test_a_membrane_more_slippery_than_the_table_leaves_the_object_where_it_is():
    slip, strain = shift(membrane=0.2, table=0.3).slide((0.0, 0.0), press((0.02, 0.0)), 0.0)
    assert slip == (0.0, 0.0)
    assert 100 * strain[0] == pytest.approx(0.2)


def test_pressed_straight_down_or_let_go_nothing_slides():
    assert shift().slide((0.0, 0.0), press(), 0.01) == ((0.0, 0.0), (0.0, 0.0))
    assert shift().slide((0.003, 0.0), press((0.01, 0.0), force=0.0, depth=0.0), 0.01) == ((0.0, 0.0), (0.0, 0.0))
    assert shift().slide((0.0, 0.0), press(sideways=(0.0, -0.4)), 0.0)[0][1] < 0


def test_the_specimen_moves_with_what_slid_and_keeps_its_own_answer():
    specimen = scene(RING).object.specimen(Active([shift()]))
    assert (specimen.memory, specimen.timeless) == (0.1, True)
    start = specimen.start()
    after = specimen.after(start, press((0.010, 0.0)))
    standing = specimen.standing(after, 0.0)
    assert 0.003 < standing.x < 0.013
    assert standing.y == pytest.approx(-0.002)
    assert specimen.standing(start, 0.0).x == pytest.approx(0.003)
    paper = scene("{type: paper_box, length: 40 mm, width: 40 mm, height: 40 mm}").object
    empty = Compliance.Parameters()
    both = paper.specimen(Active([Compliance(empty), RoofSag(RoofSag.Parameters()), shift()]))
    law = both.law(both.after(both.start(), press((0.010, 0.0))), 0.0)
    assert law(1e-3)[0] == pytest.approx(
        paper.specimen(Active([Compliance(empty), RoofSag(RoofSag.Parameters())])).law(None, 0.0)(1e-3)[0]
    )


def test_without_the_effect_it_stays():
    assert scene(RING).object.specimen(Active()).memory is None


@pytest.mark.parametrize("travel", [0.0, 0.002, 0.01, 0.03])
def test_the_estimate_is_what_slides_under_the_force_estimated(travel):
    thing = scene(RING, f"{travel * 1e3} mm")
    case = Case(thing, thing.object.rough())
    (size,) = RigidShift.sizes(case, RigidShift.Parameters())
    moved = press((travel, 0.0), case.force, depth=case.depth)
    slip, _ = shift().slide((0.0, 0.0), moved, thing.object.own_weight)
    assert size.value == pytest.approx(slip[0], abs=1e-9)


def test_the_estimate_of_a_fixed_object_is_nothing():
    fixed = SimpleNamespace(rough=SimpleNamespace(loose=False, weight=1.0), force=1.0)
    assert list(RigidShift.sizes(fixed, RigidShift.Parameters())) == []
