import importlib.util
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception import Dimension, cloud_of, fit_object
from stretch_bt.perception.solids.bend import fit_bend
from stretch_bt.perception.solids.domes import Dome, domes_of, radii_of
from stretch_bt.perception.solids.profile import HeightProfile
from stretch_bt.perception.solids.result import pooled
from stretch_bt.perception.solids.views import views_of
from stretch_bt.perception.solids.wire import no_wire_there

_spec = importlib.util.spec_from_file_location("membranes", Path(__file__).with_name("membranes.py"))
m = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(m)
MM = 1e-3
MIDDLE = ((0.0, 0.0),)  # a single press, which shows all of a small top

# what is felt, its top, its kind, its dimensions
SHAPES = {
    "block": (m.block(0.040, 0.030, 0.040), 0.040, "block", {"length": 0.040, "width": 0.030, "height": 0.040}),
    "turned block": (m.block(0.036, 0.028, 0.040, 0.5), 0.040, "block", {"length": 0.036, "width": 0.028}),
    "disc": (m.disc(0.030, 0.040), 0.040, "disc", {"radius": 0.015, "diameter": 0.030, "height": 0.040}),
    "ridge": (m.ridge(0.040, 0.030), 0.030, "ridge", {"length": 0.040, "height": 0.030}),
    "turned ridge": (m.ridge(0.040, 0.030, -0.6), 0.030, "ridge", {"length": 0.040, "height": 0.030}),
    "ridge turned the other way": (m.ridge(0.040, 0.030, 0.7), 0.030, "ridge", {"length": 0.040, "height": 0.030}),
    "half-cylinder": (
        m.half_cylinder(0.040, 0.020, 0.3),
        0.020,
        "half_cylinder",
        {"length": 0.040, "radius": 0.020, "height": 0.020},
    ),
    "domes": (
        m.domes([(-0.019, 0.014), (0.006, 0.011)]),
        0.014,
        "domes",
        {"radius_1": 0.014, "radius_2": 0.011, "height": 0.014},
    ),
    "ball": (m.raised(m.domes([(0.0, 0.016)]), 0.016), 0.032, "domes", {"radius_1": 0.016, "height": 0.032}),
    "point": (m.point(0.034), 0.034, "point", {"height": 0.034}),
    "wire circle": (m.wire_circle(0.050, 0.022), 0.022, "wire_circle", {"radius": 0.025, "height": 0.022}),
    "wire triangle": (m.wire_triangle(0.050, 0.022), 0.022, "wire_triangle", {"side": 0.050, "height": 0.022}),
}


#: shapes that another of the same kind stands for
ALIKE = ("turned block", "ridge", "ridge turned the other way")


def felt_of(name, presses=2):
    return _felt(name, presses)


def found_of(name, presses=2):
    return _found(name, presses)


@cache  # which would keep a default apart from the same number that is given
def _felt(name, presses):
    height, top, *_ = SHAPES[name]
    return m.felt(height, top, places=m.PLACES[-presses:])


@cache
def _found(name, presses):
    return fit_object(*_felt(name, presses), fillet_sd=0.2 * MM)  # whose edges are known


@pytest.mark.parametrize("presses", [2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in ALIKE else n for n in SHAPES])
def test_a_shape_is_found_with_its_dimensions_within_their_deviations(name, presses):
    *_, kind, known = SHAPES[name]
    found = found_of(name, presses)
    assert found.kind == kind, found.ranking
    assert found.ranking[0].evidence == 0.0
    for dimension, value in known.items():
        measured = found.dimensions[dimension]
        assert abs(measured.value - value) < 3 * measured.sd, dimension
        assert abs(measured.value - value) < 0.6 * MM, dimension
        assert measured.sd < 0.7 * MM, dimension
    assert found.height == found.dimensions["height"].value


@pytest.mark.parametrize(
    ("over", "share", "sure"),
    [
        (0.45, 0.5, True),
        (0.54, 0.5, True),
        (0.9, 1.0, True),
        (1.3, 1.0, True),
        (5.0, 1.0, True),
        (0.3, 0.3, False),
        (0.7, 0.7, False),
    ],
)
def test_a_dome_is_a_half_sphere_or_a_whole_one_where_its_arc_says_so_and_else_as_round_as_that(over, share, sure):
    height = Dimension(0.030, 0.2 * MM, {})
    (radius,) = radii_of([Dome(np.zeros(2), height, over * height.value, 0.006)], 0.0)
    assert radius.value == pytest.approx(share * height.value, rel=0.02 if sure else 0.15)
    assert (radius.sd < 0.03 * height.value) == sure
    assert radius.seen == pytest.approx(over * height.value)


FLAT_CREST = m.crest(0.032, 0.035, lambda v: -(v**2) / 2 / 0.14, 0.0, 0.0)
LEANING = m.block(0.026, 0.020, 0.040)


@pytest.mark.parametrize(
    ("height", "top", "kind"),
    [(FLAT_CREST, 0.035, "half_cylinder"), (lambda x, y: LEANING(x, y) + 0.1 * y, 0.041, "ridge")],
)
def test_a_top_that_is_too_flat_or_falls_on_one_side_alone_is_no_crest(height, top, kind):
    found = fit_object(*m.felt(height, top))
    assert found.kind not in ("half_cylinder", "ridge"), found.ranking
    assert next(w.refused for w in found.ranking if w.kind == kind)


def test_a_membrane_that_is_bent_by_its_clamps_adds_no_dome():
    height = m.domes([(-0.019, 0.014), (0.006, 0.011)])

    def bent(x, y):
        return np.maximum(height(x, y), 4 * MM) + 4 * MM * np.exp(
            -((x - 0.020) ** 2 + (y - 0.030) ** 2) / (7 * MM) ** 2
        )

    bent.touched = height.touched
    found = fit_object(*m.felt(bent, 0.014))
    assert [name for name in found.dimensions if name.startswith("radius_")] == ["radius_1", "radius_2"]


def test_a_membrane_that_hangs_over_a_dome_does_not_say_how_round_it_is():
    lies = m.domes([(0.0, 0.012)])

    def hangs(x, y):
        return np.maximum(lies(x, y), 12.5 * MM)

    rng = np.random.default_rng(3)
    presses = [(lies, 9 * MM), (lies, -9 * MM), (hangs, 0.0), (hangs, 2 * MM), (hangs, -2 * MM)]
    contacts = [m.contact(height, (x, 0.0), 6 * MM, rng, 0.03 * MM, 12.5 * MM) for height, x in presses]
    (found,) = domes_of(views_of(contacts), [np.zeros(2)])
    assert found.height.value == pytest.approx(12 * MM, abs=0.2 * MM)
    assert found.radius == pytest.approx(12 * MM, rel=0.3)


def test_humps_of_one_dome_are_one_dome_at_its_peak():
    rng = np.random.default_rng(5)
    height = m.domes([(0.0, 0.014)])
    views = views_of([m.contact(height, (x, 0.0), 6 * MM, rng, 0.03 * MM, 14 * MM) for x in (-3 * MM, 0.0, 3 * MM)])
    for humps in ([(3.5 * MM, 2 * MM)], [(-4 * MM, 1 * MM), (4 * MM, 0.0)]):
        (found,) = domes_of(views, [np.array(hump) for hump in humps])
        assert np.hypot(*found.middle) < 0.5 * MM
        assert found.height.value == pytest.approx(14 * MM, abs=0.1 * MM)


def test_a_shape_stands_where_it_stands_and_is_turned_as_it_is():
    found = found_of("turned block")
    assert np.abs(found.middle - [0.0, 0.0, 0.040]).max() < 0.2 * MM
    assert found.heading == pytest.approx(0.5, abs=0.02)
    found = found_of("turned ridge")
    assert found.heading == pytest.approx(-0.6, abs=0.02)


def test_a_shape_with_less_evidence_is_turned_as_its_own_outline_is():
    felt = m.felt(m.rounded(28 * MM, 24 * MM, 10 * MM, 20 * MM, 0.5), 20 * MM, places=MIDDLE)
    found = fit_object(*felt)
    assert [w.kind for w in found.ranking[:2]] == ["extents", "disc"]
    assert fit_object(*felt, shape="block").heading == pytest.approx(0.5, abs=0.03)


def test_inside_a_wire_there_is_nothing_and_inside_a_block_there_is():
    away = np.linspace(0.0, 0.03, 61)
    circle = found_of("wire circle")
    for angle in np.linspace(0.0, 2 * np.pi, 7):
        places = away[:, None] * [np.cos(angle), np.sin(angle)]
        assert away[no_wire_there(circle, places, 1 * MM)].max() == pytest.approx(22 * MM, abs=0.8 * MM)
    triangle = found_of("wire triangle")
    assert triangle.heading == pytest.approx(0.3, abs=0.03)
    for angle, inside in ((0.3, 1.0), (0.3 + np.pi / 3, 2.0), (0.3 + 2 * np.pi / 3, 1.0)):
        places = away[:, None] * [np.cos(angle), np.sin(angle)]
        ends = inside * (0.050 / (2 * np.sqrt(3)) - 2 * MM)
        assert away[no_wire_there(triangle, places, 1 * MM)].max() == pytest.approx(ends, abs=0.5 * MM * (1 + inside))
    block = found_of("block")
    assert not no_wire_there(block, places, 1 * MM).any()


def test_a_dimension_says_by_how_much_the_roundness_of_the_membrane_moved_it():
    length = found_of("block").dimensions["length"]
    assert length.steps["membrane"] == pytest.approx(2 * m.inset(), abs=0.1 * MM)
    assert length.seen == pytest.approx(0.040 - 2 * (m.inset() + m.GENTLE), abs=0.15 * MM)
    sharper = fit_object(*felt_of("block"), fillet=0.2 * MM, fillet_sd=0.0)
    assert sharper.dimensions["length"].value < length.value - 1.0 * MM


#: of a dimension, the least and the most change over the change of the radius of all edges, or of the wire
MOVED = {
    ("wire triangle", "side"): (0.3, 1.5),
    ("ridge", "length"): (2.0, 2.0),  # both ends, each by as much
    ("half-cylinder", "length"): (1.0, 2.0),
    ("block", "length"): (1.0, 2.0),
}


@pytest.mark.parametrize(("name", "dimension"), MOVED)
def test_the_error_of_one_radius_moves_all_ends_and_sides_of_an_object_alike(name, dimension):
    felt, kind = felt_of(name), SHAPES[name][2]
    sd = [fit_object(*felt, shape=kind, fillet_sd=sd).dimensions[dimension].sd for sd in (0.0, 1 * MM)]
    least, most = MOVED[name, dimension]
    share = np.sqrt(sd[1] ** 2 - sd[0] ** 2) / MM
    assert least - 1e-6 <= share <= most + 1e-6
    if name != "ridge":  # a sharp one's ends are where they are whatever the radius is
        values = [fit_object(*felt, shape=kind, fillet=r * MM).dimensions[dimension].value for r in (0.9, 1.1)]
        assert abs(values[1] - values[0]) / 0.2 / MM == pytest.approx(share, rel=0.1)


def test_a_crest_on_a_plinth_has_the_radius_of_its_arc():
    on_table, raised = (m.half_cylinder(0.040, 0.020), lambda x, y: m.half_cylinder(0.040, 0.020)(x, y) + 0.020)
    low = fit_object(*m.felt(on_table, 0.020, places=MIDDLE), shape="half_cylinder").dimensions["radius"]
    high = fit_object(*m.felt(raised, 0.040, places=MIDDLE), shape="half_cylinder").dimensions["radius"]
    assert low.sd < 0.5 * MM
    assert "table" not in high.steps
    assert high.sd > 2 * MM
    assert abs(high.value - 0.020) < 2 * high.sd


def test_a_shape_that_is_asked_for_is_taken_or_refused():
    felt = m.felt(m.disc(0.030, 0.040), 0.040, places=MIDDLE)
    assert fit_object(*felt, shape="disc").kind == "disc"
    assert fit_object(*felt, shape="wire_circle").kind == "wire_circle"
    with pytest.raises(IllConditioned, match="no block fits"):
        fit_object(*m.felt(m.point(0.034), 0.034, places=MIDDLE), shape="block")
    with pytest.raises(InvalidInput, match="shape is 'auto' or one of"):
        fit_object(*felt, shape="egg")
    with pytest.raises(InvalidInput, match="fillet"):
        fit_object(*felt, fillet=-1 * MM)


def test_a_top_wider_than_every_view_is_measured_between_views_or_as_extents():
    height = m.block(0.100, 0.030, 0.040)
    felt = m.felt(height, 0.040, places=MIDDLE)
    middle = fit_object(*felt)
    assert middle.kind == "extents"
    assert middle.height == pytest.approx(0.040, abs=0.3 * MM)
    assert "press nearer" in middle.ranking[0].refused
    with pytest.raises(IllConditioned, match="press nearer"):
        fit_object(*felt, shape="block")


def test_hard_cases_end_with_a_reason():
    cloud, contacts = felt_of("block")
    with pytest.raises(NoContact, match="no contact"):
        fit_object(cloud, [])
    with pytest.raises(NoContact, match="no point"):
        fit_object(cloud_of(np.zeros((0, 3)), 1e-4), contacts)
    with pytest.raises(InvalidInput, match="pose"):
        fit_object(cloud, [replace(contacts[0], pose=None)])
    with pytest.raises(InvalidInput, match="frame of the hand"):
        fit_object(replace(cloud, frame="hand"), contacts)
    small = replace(contacts[0], labels=np.where(contacts[0].labels == 2, 2, 255)[:8], surface=contacts[0].surface[:8])
    with pytest.raises(NoContact, match="takes 200"):
        fit_object(cloud, [small])


def test_two_objects_are_told_and_not_measured_as_one():
    one, other = m.block(0.018, 0.018, 0.040), m.block(0.018, 0.018, 0.040)

    def both(x, y):
        return np.maximum(one(x - 0.018, y), other(x + 0.018, y))

    with pytest.raises(IllConditioned, match="two tops"):
        fit_object(*m.felt(both, 0.040))


def test_points_on_one_line_carry_no_shape():
    _, contacts = m.felt(m.block(0.040, 0.030, 0.040), 0.040, places=MIDDLE)
    labels = np.full_like(contacts[0].labels, 255)
    labels[100:102] = contacts[0].labels[100:102]
    line = replace(contacts[0], labels=labels)
    points = np.column_stack([np.linspace(0, 0.02, 200), np.zeros(200), np.full(200, 0.04)])
    with pytest.raises(IllConditioned, match="line"):
        fit_object(cloud_of(points, 1e-4), [line])


@pytest.mark.parametrize("seed", range(5))
def test_a_bend_is_where_its_straight_parts_meet_within_its_deviation(seed):
    rng = np.random.default_rng(seed)
    at = np.arange(-12.0, 12.0, 0.4) * MM
    place, length = rng.uniform(-1, 1) * MM, rng.uniform(0.5, 2.5) * MM
    z = 0.03 + 0.02 * (at - place) - 0.5 * m.bend(at - place, length) + 2e-6 * rng.normal(size=at.size)
    found = fit_bend(HeightProfile(at, z, np.full(at.size, 20.0), 10e-6), 0.5 * MM)
    assert abs(found.place - place) < 3 * found.sd < 0.3 * MM
    assert abs(found.length - length) < 3 * found.length_sd < 0.6 * MM
    assert (found.near, found.far) == pytest.approx((0.02, -0.48), abs=0.01)
    assert found.surface == pytest.approx(0.03 - 0.5 * length / 2, abs=0.02 * MM)


def test_a_profile_without_a_bend_has_none():
    at = np.arange(-12.0, 12.0, 0.4) * MM
    for z, reason in ((np.full(at.size, 0.03), "bend down"), (0.03 + 0.5 * np.maximum(at, 0.0), "bend down")):
        with pytest.raises(IllConditioned, match=reason):
            fit_bend(HeightProfile(at, z, np.ones(at.size), 1e-5), 0.0)
    with pytest.raises(IllConditioned, match="too little"):
        fit_bend(HeightProfile(at[:20], 0 * at[:20], np.ones(20), 1e-5), 10 * MM)


def test_pooling_widens_where_places_differ():
    one, other = Dimension(0.010, 1e-4, {"membrane": 1e-3}), Dimension(0.012, 1e-4, {"membrane": 2e-3})
    apart = pooled([one, other])
    assert apart.value == pytest.approx(0.011)
    assert apart.sd > 0.9e-3
    assert apart.steps["membrane"] == pytest.approx(1.5e-3)
    assert pooled([one, one], shared=1e-3).sd == pytest.approx(1e-3, rel=0.01)
