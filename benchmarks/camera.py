"""The twin's depth camera: accuracy of its images and of its noise, beside CPU time.

Run with `python benchmarks/camera.py [FOLDER]`; with a folder of frames of a real SR305 (16-bit PNG, counts of 0.125 mm) it
compares their texture with the preset's. Times are medians of one thread. `stretch-bt accuracy camera` measures the error and the time
of an image alone, over the pitch of its grid.
"""

from __future__ import annotations

import sys
import time
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.camera.rendering import CROP, DISTANCE, PITCHES, TABLE, points_of, solved, timed
from stretch_bt.accuracy.perception.render import render
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import (
    average_frames,
    find_contact,
    fit_contact_sphere,
    load_depth_png,
    mask_membrane,
    measure_contact,
    track_height,
)
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.fold_kernel import look_through
from stretch_bt.simulation.camera.presets import PRESETS
from stretch_bt.simulation.camera.renderer import DepthRenderer
from stretch_bt.simulation.camera.skin import Grid, RoundBump
from stretch_bt.simulation.camera.statistics import deviations_of, texture_of
from stretch_bt.simulation.camera.view import SR305
from stretch_bt.simulation.effects import registry
from stretch_bt.simulation.effects.base import CameraEffect, Exposure
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.result import Shape
from stretch_bt.simulation.membrane.surface import Surface
from stretch_bt.simulation.scene.file import parse_scene

STRETCH, DEPTH = 0.03, 0.010
FACETS = 4  # pieces that a straight one is cut into, which changes nothing but shows it to the renderer
BODIES: dict[str, tuple[Indenter, str]] = {
    "sphere 60": (Sphere(0.06), "{type: sphere, diameter: 60 mm, rigid: true}"),
    "cylinder 20": (Cylinder(0.02), "{type: cylinder, diameter: 20 mm, height: 40 mm, rigid: true}"),
}
RUNS, FRAMES = 12, 8

Image = npt.NDArray[np.float32]


def faceted(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the same surface made of straight pieces."""
    for axis in (0, 1):
        places = np.arange(FACETS * (points.shape[axis] - 1) + 1) / FACETS
        low = np.minimum(places.astype(int), points.shape[axis] - 2)
        share = (places - low).reshape([-1 if a == axis else 1 for a in range(3)])
        points = points.take(low, axis) * (1 - share) + points.take(low + 1, axis) * share
    return points


def measured(frame: DepthFrame, name: str) -> tuple[float, float]:
    """Return the height, mm, and the radius or diameter, mm, that perception finds."""
    contact = find_contact(mask_membrane(frame, gauge=0.1, width=0.09, stretch=STRETCH))
    height = track_height(contact.surface, contact.labels != 255, contact.labels).value
    if name.startswith("sphere"):
        return 1e3 * height, 1e3 * fit_contact_sphere(contact).radius
    return 1e3 * height, 1e3 * measure_contact(contact.surface, contact.labels, stretch=STRETCH).diameter_i


def framed(raw: npt.NDArray[np.uint16], unit: float) -> DepthFrame:
    return DepthFrame(raw, unit, CROP, 0.0, 0, DISTANCE, hand_height=0.0, stretch=STRETCH)


def clean(depth: Image) -> DepthFrame:
    """Return a frame with 0.02 mm of white noise, the same in all, as no estimator trusts a frame without any."""
    unit = 3.5e-6  # counts as fine as 16 bits allow at 200 mm
    seen = (depth > 0) & (depth < 0.225)
    off = np.random.default_rng(0).normal(0, 2e-5, depth.shape)
    return framed(np.where(seen, np.rint((depth + off) / unit), 0).astype(np.uint16), unit)


def rendering() -> None:
    print("perception on rendered images: body, pitch mm | height, size off by um | the same of straight facets um")
    for name, (body, _) in BODIES.items():
        shape = solved(body, STRETCH, DEPTH).shape
        truth = render(shape, CROP, DISTANCE)[0]
        right = measured(clean(truth.astype(np.float32)), name)
        print(f"  {name}: height {right[0]:.4f}, size {right[1]:.4f} mm")
        for pitch in PITCHES:
            print(rendered(name, shape, pitch, right), flush=True)


def rendered(name: str, shape: Shape, pitch: float, right: tuple[float, float]) -> str:
    points, renderer = points_of(shape, pitch), DepthRenderer(CROP, DISTANCE)
    mine = 1e3 * (np.array(measured(clean(renderer.render(Grid(points), TABLE)), name)) - right)
    flat = renderer.render(Grid(faceted(points)), TABLE)
    facets = 1e3 * (np.array(measured(clean(flat), name)) - right)
    return f"  {name:11s} {1e3 * pitch:4.2f} | {mine[0]:+6.2f} {mine[1]:+7.2f} | {facets[0]:+6.2f} {facets[1]:+8.2f}"


def other_ways() -> None:
    skin = Grid(points_of(solved(Sphere(0.06), STRETCH, DEPTH).shape, 0.7e-3))
    bump = Surface(0.010, 0.0075, 0.0025, 0.045, 0.0225)
    profile = RoundBump(bump, (0.0, 0.0), 0.09, 0.13)
    for lens, words in ((CROP, "crop"), (SR305, "full")):
        renderer = DepthRenderer(lens, DISTANCE)
        renderer.render(skin)
        maps = renderer.view.project(np.pad(skin.points, ((2, 2), (3, 3), (0, 0)), mode="reflect", reflect_type="odd"))
        image = np.zeros((lens.height, lens.width), np.float32)
        _, through = timed(lambda m=maps, i=image: look_through(m[0], m[1], m[2], 2, 3, i), 5)  # type: ignore[misc]
        _, closed = timed(lambda r=renderer: r.render(profile, TABLE))  # type: ignore[misc]
        bent = registry()["lens_distortion"]
        assert issubclass(bent, CameraEffect)
        distorted = DepthRenderer(bent(bent.Parameters()).lens(lens), DISTANCE)
        distorted.render(skin)
        _, lensed = timed(lambda r=distorted: r.render(skin, TABLE))  # type: ignore[misc]
        print(f"  {words}: with a depth buffer, where the surface hides part of itself {1e3 * through:.1f} ms, "
              f"closed-form profile {1e3 * closed:.2f} ms, through a distorting lens {1e3 * lensed:.2f} ms")  # fmt: skip


def effects_of(preset: str, names: set[str] | None = None) -> list[CameraEffect]:
    """Return the effects of a preset in their order, or only the named ones."""
    found = []
    for name, effect in registry().items():
        if name in PRESETS[preset] and (names is None or name in names):
            assert issubclass(effect, CameraEffect)
            found.append(effect(PRESETS[preset][name]))
    return found


def exposure(depth: Image, lens: Intrinsics, number: int, seed: int) -> Exposure:
    def random(name: str, k: int) -> np.random.Generator:
        return np.random.default_rng((seed, zlib.crc32(name.encode()), k + (1 << 20)))

    return Exposure(np.array(depth, np.float32, order="C"), lens, number / 30, number, 30.0, random, 1e-5)


def noise() -> None:
    print("noise: effect of `bench` | asked: sd mm, correlation 1 px, of frames, share lost | measured on 60 frames"
          " | ms crop, full")  # fmt: skip
    totals = [0.0, 0.0]
    for effect in effects_of("bench"):
        given = effect.parameters
        asked = (getattr(given, "sd", 0.0), getattr(given, "kernel", 0.0), getattr(given, "memory", 0.0))
        beside = np.exp(-1 / (4 * asked[1] ** 2)) if asked[1] else 0.0
        after = 1.0 if effect.name == "fixed_pattern" else asked[2]
        lost = given.share if effect.name == "dropout" else 0.0
        flat = np.full((333, 213), 0.2, np.float32)
        seeds = range(60) if effect.name == "fixed_pattern" else [0]
        found = [run(effect, flat, seed, 2 if len(seeds) > 1 else 60) for seed in seeds]
        sd = np.sqrt(np.mean([f.sd**2 for f in found]))
        spent = [cost(effect, shape) for shape in ((333, 213), (480, 640))]
        totals = [a + b for a, b in zip(totals, spent, strict=True)]
        print(f"  {effect.name:17s} | {1e3 * asked[0]:.3f} {beside:5.3f} {after:5.3f} {lost:6.4f} | {1e3 * sd:.3f}"
              f" {np.mean([f.beside[0] for f in found]):5.3f} {np.mean([f.after for f in found]):5.3f}"
              f" {np.mean([f.lost for f in found]):6.4f} | {spent[0]:.2f} {spent[1]:.2f}")  # fmt: skip
    print(f"  all of `bench`: {totals[0]:.2f} ms a frame on the crop, {totals[1]:.2f} ms on 480 x 640")


def run(effect: CameraEffect, flat: Image, seed: int, count: int) -> Any:
    frames = []
    for number in range(count):
        seen = exposure(flat, CROP, number, seed)
        effect.expose(seen)
        frames.append(counts(seen) * np.float32(seen.unit) if effect.name == "quantisation" else seen.depth)
    return deviations_of(frames, flat)


def cost(effect: CameraEffect, shape: tuple[int, int]) -> float:
    flat = np.full(shape, 0.2, np.float32)
    flat[:, :20] = 0.25
    lens = SR305.cropped(0, shape[0], 0, shape[1])
    spent = []
    for number in range(40):
        seen = exposure(flat, lens, number, 1)
        start = time.process_time()
        effect.expose(seen)
        spent.append(time.process_time() - start)
    return 1e3 * float(np.median(spent))


def texture(folder: Path) -> None:
    lens = Intrinsics(476.007, 476.007, 313.683, 242.755, 640, 480)
    real = texture_of(load_depth_png(p, unit=0.125e-3, intrinsics=lens) for p in sorted(folder.glob("*.png")))

    def frame(number: int, depth: float) -> DepthFrame:
        plane = np.broadcast_to(depth + np.linspace(0, 3e-3, 640), (480, 640))
        seen = exposure(plane.astype(np.float32), lens, number, 0)
        for effect in effects_of("sr305_texture"):
            effect.expose(seen)
        return DepthFrame(counts(seen), seen.unit, lens, 0.0, number)

    made = texture_of(frame(k, z) for k, z in enumerate((0.55, 0.67, 0.75, 0.83)))
    for words, found in (("real SR305", real), ("sr305_texture", made)):
        print(
            f"  {words:13s}: sd {found.growth * 1e-3:.2e} z^2 mm (z in mm), correlation at 1, 2, 3 px {found.beside.round(3)}"
        )


def left_over() -> None:
    print(f"what is left, mm, of {FRAMES} frames averaged, over {RUNS} runs: sd of perception's answer | estimate")
    for name, (body, words) in BODIES.items():
        scene = parse_scene(
            f"format: stretch-scene/1\nobject: {words}\nconditions: {{stretch: 30 mm, frames: {FRAMES}}}\n"
        )
        case = Case(scene, scene.object.rough())
        depth = DepthRenderer(CROP, DISTANCE).render(Grid(points_of(solved(body, STRETCH, DEPTH).shape, 0.7e-3)), TABLE)
        for effect in ("white_noise", "correlated_noise", "fixed_pattern"):
            made = registry()[effect]
            said = {s.observable: 1e3 * s.value for s in made.sizes(case, PRESETS["bench"][effect])}
            answers, why = [], ""
            for seed in range(RUNS):
                try:
                    answers.append(measured(noisy(depth, effect, seed), name))
                except NoAnswer as none:
                    why = none.reason
            sd = np.std(answers, axis=0) if len(answers) > 2 else (np.nan, np.nan)
            print(f"  {name:11s} {effect:16s} height {sd[0]:.4f} | {said['height']:.4f}, size {sd[1]:.4f} | {said['size']:.4f}"
                  f"  {RUNS - len(answers)} refused {why}", flush=True)  # fmt: skip


def noisy(depth: Image, name: str, seed: int) -> DepthFrame:
    (effect,) = effects_of("bench", {name})
    frames = []
    for number in range(FRAMES):
        seen = exposure(depth, CROP, number, seed)
        effect.expose(seen)
        frames.append(framed(counts(seen), seen.unit))
    return average_frames(frames)


def main() -> None:
    rendering()
    other_ways()
    noise()
    if len(sys.argv) > 1:
        texture(Path(sys.argv[1]))
    left_over()


if __name__ == "__main__":
    main()
