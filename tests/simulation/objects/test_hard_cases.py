"""Objects at the limits of what a membrane can meet: an answer, or a refusal that says why."""

import pytest

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.mesh_file import load_mesh
from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron
from stretch_bt.simulation.membrane.indenters.shapes import arch
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

HAND = {"shear_modulus": SHEAR_MODULUS, "mount_prestretch": MOUNT_PRESTRETCH}
POST = "{type: box, length: 0.3 mm, width: 0.3 mm, height: 20 mm, edge: 0.1 mm, rigid: true}"
WIDE = "{type: box, length: 120 mm, width: 150 mm, height: 20 mm, rigid: true}"
BROAD = "{type: box, length: 120 mm, width: 40 mm, height: 20 mm, rigid: true}"
CUBE = "{type: box, length: 40 mm, width: 40 mm, height: 20 mm, rigid: true}"
POINT = "{type: pyramid, width: 40 mm, height: 30 mm, rigid: true}"
PAIR = (
    "{type: several, objects: [{type: box, length: 20 mm, width: 20 mm, height: 40 mm, rigid: true, position: {y: -15 mm}}, "
    "{type: pyramid, width: 20 mm, height: 41 mm, rigid: true, position: {y: 15 mm}}]}"
)
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
TETRA = ([[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def body(text):
    return parse_scene(f"format: stretch-scene/1\nobject: {text}\n").object.body()


@pytest.mark.parametrize(
    ("text", "at", "depth", "low", "high"),
    [
        (BROAD, (0.0, 0.0), 0.005, 1.0, 1.7),
        (POINT, (0.0, 0.045), 0.005, 0.2, 0.8),
        (CUBE, (0.04, 0.0), 0.005, 0.1, 1.5),
        (PAIR, (0.0, 0.0), 0.008, 0.6, 1.4),
    ],
    ids=["wider than the membrane", "a point next to the clamp", "half beside the free edge", "two side by side"],
)
def test_an_answer(text, at, depth, low, high):
    assert low < press(body(text), 0.0, depth, at=at, **HAND).force < high


@pytest.mark.parametrize(
    ("text", "at", "says"),
    [
        (POST, (0.0, 0.0), "no equilibrium"),
        (WIDE, (0.0, 0.0), "overlaps a clamp"),
        (CUBE, (0.0, 0.045), "overlaps a clamp"),
        (CUBE, (0.12, 0.0), "does not reach"),
    ],
    ids=["narrower than a pixel", "wider and longer than the membrane", "at the clamp", "beside the membrane"],
)
def test_a_refusal_says_why(text, at, says):
    with pytest.raises(NoEquilibrium, match=says):
        press(body(text), 0.0, 0.005, at=at, **HAND)


@pytest.mark.parametrize(
    ("vertices", "triangles", "edge", "says"),
    [
        ([], [], 1e-3, "empty"),
        (SQUARE, [[0, 1, 2], [0, 2, 3]], 1e-3, "open"),
        (TETRA[0], [t[::-1] for t in TETRA[1]], 1e-3, "inwards"),
        (TETRA[0], TETRA[1], 30.0, "thinner"),
        (TETRA[0], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 7]], 1e-3, "vertices 0 to 3"),
    ],
    ids=["empty", "open", "inside out", "thinner than its fillets", "no such vertex"],
)
def test_a_surface_that_is_none(vertices, triangles, edge, says):
    with pytest.raises(InvalidInput, match=says):
        Polyhedron(vertices, triangles, edge)


def test_an_arch_is_a_box_from_above():
    from_above = press(arch(0.06, 0.03, 0.03, 0.03), 0.0, 0.008, **HAND).force
    assert from_above == pytest.approx(press(Box(0.06, 0.03), 0.0, 0.008, **HAND).force, rel=5e-3)


trimesh = pytest.importorskip("trimesh", reason="mesh files need the extra 'mesh'")


def test_a_box_in_a_file_is_that_box(tmp_path):
    trimesh.creation.box((40, 30, 20)).export(tmp_path / "box.stl")
    (tmp_path / "box.yaml").write_text(
        "format: stretch-scene/1\nobject: {type: mesh, file: box.stl, edge: 1 mm, rigid: true}\n"
    )
    thing = load_scene(tmp_path / "box.yaml").object
    assert thing.top == pytest.approx(0.020, abs=1e-9)
    assert thing.known() == pytest.approx({"length": 0.04, "width": 0.03, "height": 0.02})
    assert press(thing.body(), 0.0, 0.01, **HAND).force == pytest.approx(
        press(Box(0.04, 0.03), 0.0, 0.01, **HAND).force, rel=5e-3
    )


def test_finer_meshes_of_a_sphere_approach_it(tmp_path):
    exact, errors = press(Sphere(0.03), 0.0, 0.008, **HAND).force, []
    for level in (2, 3, 4):
        path = tmp_path / f"{level}.ply"
        trimesh.creation.icosphere(subdivisions=level, radius=15).export(path)
        errors.append(abs(press(load_mesh(path, 1e-3, 2e-3), 0.0, 0.008, **HAND).force / exact - 1))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 5e-3


@pytest.mark.parametrize("content", ["", "solid x\nendsolid x\n"])
def test_a_file_without_a_body(tmp_path, content):
    path = tmp_path / "none.stl"
    path.write_text(content)
    with pytest.raises(InvalidInput, match=r"cannot be read|no triangles|no surface"):
        load_mesh(path, 1e-3, 1e-3)


def test_an_open_file(tmp_path):
    trimesh.Trimesh(SQUARE, [[0, 1, 2], [0, 2, 3]]).export(tmp_path / "open.ply")
    with pytest.raises(InvalidInput, match="open"):
        load_mesh(tmp_path / "open.ply", 1e-3, 1e-4)
