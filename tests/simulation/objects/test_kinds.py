"""What holds for every kind of object, over a table of one or more scenes for each."""

import math

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput, SceneError
from stretch_bt.simulation.above import upper_surface
from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.objects.registry import kinds
from stretch_bt.simulation.scene import load_scene, parse_scene

OBJECTS = [
    "{type: box, length: 40 mm, width: 30 mm, height: 20 mm, rigid: true}",
    "{type: bridge, length: 60 mm, width: 30 mm, height: 30 mm, span: 30 mm, rigid: true}",
    "{type: cone, angle: 45 deg, height: 30 mm, rigid: true}",
    "{type: cylinder, diameter: 20 mm, height: 30 mm, stiffness: 2 N/mm}",
    "{type: half_cylinder, diameter: 40 mm, length: 50 mm, rigid: true}",
    "{type: paper_box, length: 40 mm, width: 40 mm, height: 40 mm}",
    "{type: paper_half_cylinder, diameter: 40 mm, length: 50 mm}",
    "{type: paper_pyramid, width: 40 mm, height: 35 mm}",
    "{type: prism, length: 50 mm, width: 40 mm, height: 30 mm, rigid: true}",
    "{type: pyramid, width: 40 mm, height: 30 mm, stiffness: 1 N/mm}",
    "{type: snowman, diameters: [28 mm, 22 mm, 16 mm], rigid: true}",
    "{type: sphere, diameter: 20 mm, rigid: true}",
    "{type: wire_circle, diameter: 50 mm, base: 20 mm}",
    "{type: wire_triangle, side: 50 mm, base: 20 mm}",
    "{type: several, objects: [{type: box, length: 20 mm, width: 20 mm, height: 40 mm, rigid: true, heading: 30 deg},"
    " {type: snowman, diameters: [20 mm, 30 mm], rigid: true, position: {x: 30 mm, y: 10 mm}}]}",
]


def made(text):
    return parse_scene(f"format: stretch-scene/1\nobject: {text}\n").object


@pytest.mark.parametrize("text", OBJECTS)
def test_top_and_reach_are_those_of_the_body(text):
    thing = made(text)
    parts = place(thing.body(), (0.0, 0.0), (0.0, 0.0), thing.top)
    assert max(part.top for part in parts) == pytest.approx(thing.top)
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.uniform(-0.08, 0.08, (40_000, 2)), rng.uniform(thing.base, thing.top, 40_000)])
    inside = np.min([part.gap(points).distance for part in parts], axis=0) < 0
    assert np.hypot(points[inside, 0], points[inside, 1]).max() <= thing.reach * (1 + 1e-9)
    assert inside.any()


@pytest.mark.parametrize("text", OBJECTS)
def test_it_stands_where_the_scene_has_it_and_knows_its_sizes(text):
    thing = made(text)
    specimen = thing.specimen(Active())
    standing = specimen.standing(specimen.start(), 0.0)
    assert (standing.x, standing.y, standing.heading) == (0.0, 0.0, 0.0)
    assert standing.top == thing.top
    assert specimen.law(specimen.start(), 0.0) is None
    known = thing.known()
    assert all(math.isfinite(value) and value > 0 for value in known.values())
    assert known.get("height", thing.top - thing.base) == pytest.approx(thing.top - thing.base)


def stump(folder):
    """Write a stump of a pyramid, its foot 50 mm wide and its top 30 mm, and return it as an object."""
    corners = [(x * r, y * r, z) for r, z in ((25, 0), (15, 30)) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    faces = [(4, 3, 2, 1), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {' '.join(map(str, face))}" for face in faces]
    (folder / "stump.obj").write_text("\n".join(lines))
    (folder / "scene.yaml").write_text(
        "format: stretch-scene/1\nobject: {type: mesh, file: stump.obj, rigid: true}\ndimensions: {width: 30 mm}\n"
    )
    return load_scene(folder / "scene.yaml")


def test_a_mesh_knows_no_width_that_a_press_need_not_feel(tmp_path):
    """A stump with a foot of 50 mm and a top of 30 mm was compared with its foot, whichever was felt."""
    scene = stump(tmp_path)
    assert scene.object.known() == {"height": pytest.approx(0.03)}
    assert scene.dimensions == {"width": 0.03}


def test_a_mesh_file_that_is_too_large_is_refused_unread(tmp_path, monkeypatch):
    monkeypatch.setattr("stretch_bt.simulation.membrane.indenters.mesh_file.MAX_FORM", 100)
    with pytest.raises(SceneError, match=r"stump.obj would take .*fewer triangles"):
        stump(tmp_path)


@pytest.mark.parametrize("text", OBJECTS)
def test_the_advisor_has_a_finite_size_for_every_effect_it_can_have(text):
    scene = parse_scene(
        f"format: stretch-scene/1\nobject: {text}\ntolerance: {{height: 1 mm, size: 1 mm, force: 5 %, stiffness: 5 %}}\n"
    )
    verdicts = {verdict.name: verdict for verdict in advise(scene)}
    for name in scene.object.effects:
        assert verdicts[name].estimate is None or math.isfinite(verdicts[name].estimate)


@pytest.mark.parametrize(
    "kind",
    sorted(name for name in kinds() if name.startswith(("box", "bridge", "cone", "half", "p", "snow", "wire", "sev"))),
)
def test_the_table_names_every_kind_of_solid(kind):
    if kind == "plane":
        assert made("{type: plane, height: 20 mm, rigid: true}\nfidelity: hertz").body() is None
    else:
        assert any(f"{{type: {kind}," in text for text in OBJECTS)


def test_what_has_no_body_has_no_upper_surface():
    plane = made("{type: plane, height: 20 mm, rigid: true}\nfidelity: hertz")
    with pytest.raises(InvalidInput, match="a plane has no body"):
        upper_surface(plane)


@pytest.mark.parametrize(
    ("text", "column", "says"),
    [
        ("{type: box, length: 40 mm, width: 40 mm, height: 0 mm, rigid: true}", 58, "out of bounds"),
        ("{type: box, length: 40 mm, width: 40 mm, height: 9 mm}", 9, "rigid: true"),
        ("{type: bridge, length: 40 mm, width: 30 mm, height: 20 mm, span: 38 mm, rigid: true}", 9, "smaller span"),
        ("{type: wire_circle, diameter: 4 mm}", 9, "no hole"),
        ("{type: wire_triangle, side: 10 mm}", 9, "no hole"),
        ("{type: mesh, file: none.stl, rigid: true}", 28, "no file"),
        ("{type: box, length: 1 cm, width: 2 cm, height: 1 cm, edge: 6 mm, rigid: true}", 9, "half its shorter side"),
        ("{type: prism, length: 8 mm, width: 4 cm, height: 3 cm, edge: 5 mm, rigid: true}", 9, "two fillets"),
        ("{type: half_cylinder, length: 5 mm, diameter: 2 cm, edge: 5 mm, rigid: true}", 9, "edge fillet"),
        ("{type: dough, yield_stress: 300 Pa}", 9, "its own weight, which is 307 Pa"),
        ("{type: pyramid, side: 2 cm, width: 1 cm, height: 1 cm, rigid: true}", 25, "known here: base, edge, heading"),
        ("{type: plane, height: 20 mm, rigid: true}", 9, "nothing stands in for a plane at sheet"),
        (
            "{type: several, objects: [{type: dough}, {type: dough}]}",
            9,
            "side by side are rigid, and a dough gives way",
        ),
        (
            "{type: several, objects: [{type: sphere, diameter: 9 mm, rigid: true},"
            " {type: paper_pyramid, width: 40 mm, height: 35 mm}]}",
            9,
            "a paper_pyramid gives way; leave it out, or write a solid with 'rigid: true' in its place",
        ),
        (
            "{type: several, objects: [{type: sphere, diameter: 9 mm, rigid: true}]}",
            34,
            "takes at least 2 entries, not 1",
        ),
        ("{type: balloon, diameter: 60 mm, pressure: 1 kPa, fill: water}", 65, "write '{type: water}'"),
        ("{type: several, objects: [{type: cube}, {type: box}]}", 35, "each object has a type"),
        (
            "{type: several, objects: [{type: sphere, diameter: 9 mm, rigid: true}, {type: sphere, diameter: 9, rigid: true}]}",
            105,
            "has no unit",
        ),
        (
            "{type: several, objects: [{type: sphere, diameter: 9 mm, rigid: true}, {type: sphere, diameter: 9 mm, stiffness: 1 N/mm}]}",
            9,
            "a sphere gives way where it has a stiffness; write 'rigid: true' for it",
        ),
    ],
)
def test_mistakes_are_found_at_their_place(text, column, says):
    with pytest.raises(SceneError, match=says) as caught:
        made(text)
    assert column in {diagnostic.column for diagnostic in caught.value.diagnostics}
