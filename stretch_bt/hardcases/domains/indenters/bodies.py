"""Objects of scenes that a membrane can hardly meet, surfaces that bound no body, and mesh files."""

from __future__ import annotations

from functools import partial
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.mesh_file import load_mesh
from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.indenters.shapes import arch
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

HAND: dict[str, Any] = {"shear_modulus": SHEAR_MODULUS, "mount_prestretch": MOUNT_PRESTRETCH}
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
CORNERS = [[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20]]
SIDES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]


def _force(text: str, depth: float, at: tuple[float, float] = (0.0, 0.0)) -> float:
    body = _body(parse_scene(f"format: stretch-scene/1\nobject: {text}\n").object)
    return press(body, 0.0, depth, at=at, **HAND).force


def _body(thing: ObjectSpec) -> Indenter | Several:
    body = thing.body()
    assert body is not None
    return body


def _surface(vertices: Any, triangles: Any, edge: float = 1e-3) -> Polyhedron:
    return Polyhedron(vertices, triangles, edge)


def _loaded(name: str, write: Any, edge: float = 1e-3) -> Polyhedron:
    """Return the body of a file that is written so."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        write(path)
        return load_mesh(path, 1e-3, edge)


def _open_file(path: Path) -> None:
    import trimesh

    trimesh.Trimesh(SQUARE, [[0, 1, 2], [0, 2, 3]]).export(path)


def _beside_file(path: Path) -> None:
    import trimesh

    box = trimesh.creation.box((40, 30, 20))
    box.apply_translation((70, -50, 300))
    box.export(path)


def _extent(body: Polyhedron) -> Any:
    return [body.vertices.min(axis=0), body.vertices.max(axis=0)]


def _box_in_scene() -> tuple[list[float], float]:
    """Return top and sizes, m, of a scene's object from a file that holds a box, and its force over the force of the box."""
    import trimesh

    with TemporaryDirectory() as folder:
        trimesh.creation.box((40, 30, 20)).export(Path(folder) / "box.stl")
        scene = Path(folder) / "box.yaml"
        scene.write_text("format: stretch-scene/1\nobject: {type: mesh, file: box.stl, edge: 1 mm, rigid: true}\n")
        thing = load_scene(scene).object
        sizes = [thing.top, *(thing.known()[name] for name in ("length", "width", "height"))]
        force = press(_body(thing), 0.0, 0.01, **HAND).force
    return sizes, force / press(Box(0.04, 0.03), 0.0, 0.01, **HAND).force


def _is_that_box(found: tuple[list[float], float]) -> bool:
    sizes, ratio = found
    near = all(abs(a - b) < 1e-9 for a, b in zip(sizes, (0.020, 0.04, 0.03, 0.02), strict=True))
    return near and abs(ratio - 1) < 5e-3


def _spheres_in_files() -> list[float]:
    """Return relative errors of forces of spheres in files, on ever finer meshes."""
    import trimesh

    def write(level: int, path: Path) -> None:
        trimesh.creation.icosphere(subdivisions=level, radius=15).export(path)

    exact = press(Sphere(0.03), 0.0, 0.008, **HAND).force
    meshes = [_loaded("ball.ply", partial(write, level), 2e-3) for level in (2, 3, 4)]
    return [abs(press(mesh, 0.0, 0.008, **HAND).force / exact - 1) for mesh in meshes]


def _written(text: str) -> Any:
    return lambda path: path.write_text(text)


#: none where the extra `mesh` is not installed
FILES: tuple[Hard, ...] = (
    (
        *group(
            "a mesh file may hold nothing, something open, or another unit's box",
            {
                "a file of nothing": (
                    partial(_loaded, "none.stl", _written("")),
                    Refusal(InvalidInput, "cannot be read|no triangles|no surface"),
                ),
                "a file without triangles": (
                    partial(_loaded, "none.stl", _written("solid x\nendsolid x\n")),
                    Refusal(InvalidInput, "cannot be read|no triangles|no surface"),
                ),
                "an open file": (partial(_loaded, "open.ply", _open_file, 1e-4), Refusal(InvalidInput, "open")),
                "a box in a file": (_box_in_scene, Check("the sizes and the force of the box", _is_that_box)),
                "a box beside the origin of its file": (
                    partial(_loaded, "beside.ply", _beside_file),
                    Value([[-0.02, -0.015, -0.02], [0.02, 0.015, 0.0]], abs=1e-9, of=_extent),
                ),
                "spheres in files": (
                    _spheres_in_files,
                    Check("errors that fall, the last below 0.5 %", lambda e: e[0] > e[1] > e[2] and e[2] < 5e-3),
                ),
            },
        ),
    )
    if find_spec("trimesh")
    else ()
)

CASES: tuple[Hard, ...] = (
    *group(
        "an object wider than the membrane, at its edge, next to a clamp, or of two parts",
        {
            "wider than the membrane": (partial(_force, BROAD, 0.005), Range(1.0, 1.7)),
            "a point next to the clamp": (partial(_force, POINT, 0.005, (0.0, 0.045)), Range(0.2, 0.8)),
            "half beside the free edge": (partial(_force, CUBE, 0.005, (0.04, 0.0)), Range(0.1, 1.5)),
            "two side by side": (partial(_force, PAIR, 0.008), Range(0.6, 1.4)),
            "an arch is a box from above": (
                lambda: (
                    press(arch(0.06, 0.03, 0.03, 0.03), 0.0, 0.008, **HAND).force
                    / press(Box(0.06, 0.03), 0.0, 0.008, **HAND).force
                ),
                Value(1.0, abs=5e-3),
            ),
        },
    ),
    *group(
        "an object that the membrane cannot meet",
        {
            "narrower than a pixel": (partial(_force, POST, 0.005), Refusal(NoEquilibrium, "no equilibrium")),
            "wider and longer than the membrane": (
                partial(_force, WIDE, 0.005),
                Refusal(NoEquilibrium, "overlaps a clamp"),
            ),
            "at the clamp": (partial(_force, CUBE, 0.005, (0.0, 0.045)), Refusal(NoEquilibrium, "overlaps a clamp")),
            "beside the membrane": (
                partial(_force, CUBE, 0.005, (0.12, 0.0)),
                Refusal(NoEquilibrium, "does not reach"),
            ),
        },
    ),
    *group(
        "triangles that bound no body have no inside",
        {
            "empty": (partial(_surface, [], []), Refusal(InvalidInput, "empty")),
            "open": (partial(_surface, SQUARE, [[0, 1, 2], [0, 2, 3]]), Refusal(InvalidInput, "open")),
            "inside out": (partial(_surface, CORNERS, [s[::-1] for s in SIDES]), Refusal(InvalidInput, "inwards")),
            "thinner than its fillets": (partial(_surface, CORNERS, SIDES, 30.0), Refusal(InvalidInput, "thinner")),
            "no such vertex": (
                partial(_surface, CORNERS, [*SIDES[:3], [0, 3, 7]]),
                Refusal(InvalidInput, "vertices 0 to 3"),
            ),
        },
    ),
    *FILES,
)
