"""Objects: the sheet's force on each shipped one beside CPU time, the cost of mesh files, and objects that give way.

    python benchmarks/objects.py

References: for a body in its scene, the same press on a mesh of half the element length; for a mesh file, the body that it
stands for; for the advisor's estimate of the force, the sheet solver.
"""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.roof_sag import RoofSag
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.mesh_file import load_mesh
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.turned import turn
from stretch_bt.simulation.membrane.press import PressResult, press
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.objects.paper import PaperSpec
from stretch_bt.simulation.scene import load_scene
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

SOLIDS = ("wooden_cube", "wooden_prism", "wooden_half_cylinder", "wooden_bridge", "glass_snowman")
FLIMSY = ("paper_cube", "paper_half_cylinder", "paper_pyramid", "wire_circle", "wire_triangle")
SCENES = (*SOLIDS, *FLIMSY, "calibration_sphere", "calibration_cylinder", "calibration_cone")
DEPTHS = (0.002, 0.005, 0.010, 0.015)
POSES = ((0.0, (0.0, 0.0)), (0.5, (0.010, 0.010)), (1.57, (-0.010, 0.015)))
SHARE = 0.25  # of the force, over a paper roof


def on_hand(
    body: Indenter | Several, depth: float, at: tuple[float, float] = (0.0, 0.0), coarsen: float = 1.0
) -> PressResult:
    """Return a press of the default hand at stretch 0."""
    settings = Settings(coarsen=coarsen)
    return press(
        body, 0.0, depth, at=at, shear_modulus=SHEAR_MODULUS, mount_prestretch=MOUNT_PRESTRETCH, settings=settings
    )


def bodies() -> None:
    """Print the presses of each shipped object, and how its force changes on a mesh twice as fine."""
    print(
        f"{'scene':21s} {'presses':>8s} {'median s':>9s} {'force at 10 mm':>15s} {'off by':>8s} {'estimate / force':>17s}"
    )
    for name in SCENES:
        scene = load_scene(name)
        body = scene.object.body()
        assert body is not None
        seconds, found = [], 0
        for heading, at in POSES:
            for depth in DEPTHS:
                began = time.process_time()
                try:
                    on_hand(turn(body, heading), depth, at)
                    found += 1
                except NoEquilibrium as error:
                    print(f"  {name} at {depth * 1e3:g} mm, turned by {heading:g}: {error}")
                seconds.append(time.process_time() - began)
        force, fine = on_hand(body, 0.010).force, on_hand(body, 0.010, coarsen=0.5).force
        case = Case(scene.with_(conditions=scene.conditions.model_copy(update={"depth": 0.010})), scene.object.rough())
        share = f"{found}/{len(seconds)}"
        print(
            f"{name:21s} {share:>8s} {median(seconds):9.3f} {force:13.3f} N {force / fine - 1:8.1%} {case.force / force:17.2f}"
        )


def meshes() -> None:
    """Print the cost and the error of a mesh file, against the body that it stands for."""
    try:
        import trimesh
    except ImportError:
        print("mesh files: trimesh is not installed, nothing measured")
        return
    exact = {"box": on_hand(Box(0.04, 0.03), 0.010), "sphere": on_hand(Sphere(0.03), 0.010)}
    made = {"box": [trimesh.creation.box((40, 30, 20))]}
    made["sphere"] = [trimesh.creation.icosphere(subdivisions=level, radius=15) for level in (2, 3, 4, 5)]
    print(
        f"\n{'mesh file':10s} {'triangles':>9s} {'load ms':>8s} {'press s':>8s} {'over exact':>10s} {'force off by':>13s}"
    )
    with tempfile.TemporaryDirectory() as folder:
        for name, several in made.items():
            for mesh in several:
                path = Path(folder) / f"{name}{len(mesh.faces)}.stl"
                mesh.export(path)
                began = time.process_time()
                body = load_mesh(path, 1e-3, 1e-3)
                loaded, result = time.process_time() - began, on_hand(body, 0.010)
                reference = exact[name]
                print(
                    f"{name:10s} {len(mesh.faces):9d} {loaded * 1e3:8.1f} {result.seconds:8.3f} "
                    f"{result.seconds / reference.seconds:10.1f} {result.force / reference.force - 1:13.2%}"
                )


def paper() -> None:
    """Print what gives way in the paper objects under the force of a press of 10 mm, and what one evaluation costs."""
    print(f"\n{'paper':21s} {'buckles at':>11s} {'force':>8s} {'walls':>9s} {'roof':>9s} {'us a law':>9s}")
    for name in SCENES:
        thing = load_scene(name).object
        if not isinstance(thing, PaperSpec):
            continue
        body, walls = thing.body(), thing.compliance()
        assert body is not None
        force = on_hand(body, 0.010).force
        has_roof = "roof_sag" in thing.effects
        sag = thing.roof(SHARE).sag(force) if has_roof else math.nan
        law = RoofSag(RoofSag.Parameters()).respond(walls, thing) if has_roof else walls
        assert law is not None
        drops, ask = np.linspace(1e-5, 1e-3, 200).tolist(), law.law(None, 0.0)
        began = time.process_time()
        for drop in drops:
            ask(drop)
        each = (time.process_time() - began) / len(drops) * 1e6
        roof = f"{sag * 1e3:6.2f} mm" if has_roof else "none"
        print(
            f"{name:21s} {walls.critical:9.2f} N {force:6.2f} N {walls.given(force) * 1e3:6.2f} mm {roof:>9s} {each:9.1f}"
        )


if __name__ == "__main__":
    paper()
    meshes()
    bodies()
