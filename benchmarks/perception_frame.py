"""What runs on every frame, accuracy beside CPU time, on presses of the sheet solver that no constant was taken from.

    python benchmarks/perception_frame.py [FRAMES]

Times are CPU milliseconds of one core, median and best. Noise: white of a standard deviation, one frame; correlated: the
mean of 8 frames of noise of 1 mm after a Gaussian of 3 px, sharing 0.6 from frame to frame.
"""

from __future__ import annotations

import dataclasses
import itertools
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy.ndimage import binary_fill_holes

from stretch_bt.accuracy.perception.analytic import camera, noisy, render, sphere_press
from stretch_bt.accuracy.perception.noise import CLEAN, CORRELATED, WHITE_03, WHITE_05, WHITE_10, Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, BodyPress, SheetView, seen
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import (
    ContactDetector,
    classify,
    curvatures,
    deproject,
    estimate_normals,
    find_contact,
    to_membrane,
    track_height,
)
from stretch_bt.perception.types import CONTACT, INVALID
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

MM = 1e3
AT = (-0.002, 0.004)
SPHERES = [
    BodyPress(Sphere(2 * r), x, d, AT)
    for r, d in ((12.5e-3, 10e-3), (20e-3, 8e-3), (20e-3, 12e-3), (25e-3, 10e-3))
    for x in (0.015, 0.045)
]
CYLINDERS = [
    BodyPress(Cylinder(w), x, d, AT)
    for w, d in ((15e-3, 8e-3), (25e-3, 6e-3), (25e-3, 12e-3))
    for x in (0.01, 0.02, 0.05)
]
SLACK = [BodyPress(Sphere(40e-3), 0.0, 12e-3, AT), BodyPress(Cylinder(25e-3), 0.0, 10e-3, AT)]
NOISES = {"white 0.3": WHITE_03, "white 0.5": WHITE_05, "white 1.0": WHITE_10, "correlated": CORRELATED}
BINS = (0.5, 0.7, 0.8, 0.9, 0.97, 0.99, 1.0001)


def cpu(call: Callable[[], Any], repeat: int = 40) -> tuple[float, float]:
    """Return median and best CPU time, ms."""
    times = []
    for _ in range(repeat):
        began = time.process_time()
        call()
        times.append(MM * (time.process_time() - began))
    return float(np.median(times)), min(times)


def cloud(frame: DepthFrame) -> tuple[Any, Any]:
    points, valid = deproject(frame)
    return to_membrane(points, PLANE_DISTANCE), valid


def on_sensor(frame: DepthFrame) -> DepthFrame:
    """Return the frame as part of the whole sensor, invalid elsewhere, as the box mask leaves it."""
    raw = np.zeros((480, 640), np.uint16)
    lens, (h, w) = frame.intrinsics, frame.raw.shape
    v, u = (480 - h) // 2, (640 - w) // 2
    raw[v : v + h, u : u + w] = frame.raw
    whole = Intrinsics(lens.fx, lens.fy, lens.cx + u, lens.cy + v, 640, 480)
    return dataclasses.replace(frame, raw=raw, intrinsics=whole)


def unmasked(noise: float) -> DepthFrame:
    """Return a frame of 640 x 480 valid pixels, of the analytic cap and skirt."""
    lens = camera(480, 640)
    depth = noisy(render(sphere_press(15e-3, np.radians(40)), lens), noise, np.random.default_rng(0))
    return DepthFrame(np.rint(depth / 0.125e-3).astype(np.uint16), 0.125e-3, lens, 0.0, 0, PLANE_DISTANCE)


def every_frame(frame: DepthFrame) -> None:
    found = find_contact(frame)
    track_height(found.surface, found.labels != INVALID, found.labels)


def speed_rows() -> Iterator[str]:
    yield "CPU ms, median (best): find_contact is crop, deprojection, cleaning, derivatives, classes, confidence, points"
    yield f"{'frame':52s} {'find_contact':>15s} {'track_height':>15s} {'both':>15s}   normals, curvatures of all pixels"
    frames = {}
    for name, noise in (("0.3", WHITE_03), ("0.5", WHITE_05)):
        for press in (SPHERES[4], CYLINDERS[4]):
            kind = type(press.indenter).__name__.lower()
            frames[f"213 x 333, {kind}, white {name} mm"] = observe(seen(press), noise, 0)
            frames[f"640 x 480 masked, {kind}, white {name} mm"] = on_sensor(observe(seen(press), noise, 0))
        frames[f"640 x 480, all valid, sphere, white {name} mm"] = unmasked(1e-4 * int(float(name) * 10))
    for name, frame in frames.items():
        points, valid = cloud(frame)
        contact = find_contact(frame)

        shown = [
            cpu(partial(find_contact, frame)),
            cpu(partial(track_height, points, valid, contact.labels)),
            cpu(partial(every_frame, frame)),
            cpu(partial(estimate_normals, points, valid)),
            cpu(partial(curvatures, points, valid)),
        ]
        yield f"{name:52s} " + " ".join(f"{m:7.2f} ({b:5.2f})" for m, b in shown)


def class_rows(frames: int) -> Iterator[str]:
    yield "classes: overlap with the true contact (intersection over union), frames without any, and the ratio of tensions"
    yield f"{'presses':22s} {'noise':11s} {'rule':7s} {'mean':>5s} {'median':>6s} {'none':>5s}   T_j/T_i: error %  stated %"
    for group, presses in (("spheres", SPHERES), ("cylinders", CYLINDERS), ("slack (stretch 0)", SLACK)):
        for name, noise in NOISES.items():
            for rule in ("mean", "either"):
                yield class_row(group, presses, name, noise, rule, max(1, frames // 8))


def class_row(group: str, presses: list[BodyPress], name: str, noise: Noise, rule: Any, frames: int) -> str:
    overlaps, ratios, none = [], [], 0
    for press in presses:
        view = seen(press)
        truth = binary_fill_holes(view.touching)
        exact = classify(*cloud(observe(view, CLEAN, 0)), rule=rule).ratio
        for seed in range(frames):
            points, valid = cloud(observe(view, noise, seed))
            found = classify(points, valid, rule=rule)
            touching, true = found.labels == CONTACT, truth & valid
            none += not touching.any()
            overlaps.append((touching & true).sum() / (touching | true).sum())
            if found.ratio is not None and exact is not None:
                ratios.append((found.ratio / exact - 1.0, found.ratio.sd / found.ratio))
    end = "-"
    if ratios:
        error, stated = np.array(ratios).T
        end = f"{100 * np.sqrt(np.mean(error**2)):7.1f}  {100 * np.mean(stated):7.1f}"
    return (
        f"{group:22s} {name:11s} {rule:7s} {np.mean(overlaps):5.2f} {np.median(overlaps):6.2f}"
        f" {none / len(overlaps):5.2f}   {end:>20s}"
    )


def confidence_rows(frames: int) -> Iterator[str]:
    yield "confidence: stated beside the share of labels 'contact' or 'not contact' that is right, where raised or touching"
    yield f"{'noise':11s} " + " ".join(f"{f'{a:.2f}-{min(b, 1):.2f}':>20s}" for a, b in itertools.pairwise(BINS))
    for name, noise in NOISES.items():
        stated, right = [], []
        for press in SPHERES + CYLINDERS:
            view = seen(press)
            truth = binary_fill_holes(view.touching)
            for seed in range(max(1, frames // 8)):
                points, valid = cloud(observe(view, noise, seed))
                found = classify(points, valid)
                asked = (found.labels != INVALID) & ((found.labels > 0) | truth)
                stated.append(found.confidence[asked])
                right.append(((found.labels == CONTACT) == truth)[asked])
        said, was = np.concatenate(stated), np.concatenate(right)
        cells = []
        for low, high in itertools.pairwise(BINS):
            some = (said >= low) & (said < high)
            cells.append(f"{said[some].mean():.3f}->{was[some].mean():.3f} ({some.mean():.2f})" if some.any() else "-")
        yield f"{name:11s} " + " ".join(f"{cell:>20s}" for cell in cells)


def height_rows(frames: int) -> Iterator[str]:
    yield "height of a flat top, mm: labels of the frame itself; the bound is for the mean over the true contact"
    yield f"{'cylinder':30s} {'noise':34s} {'bias':>8s} {'sd':>7s} {'rms/bound':>9s} {'stated/sd':>9s} refused"
    flying = {
        "white 1 mm": Noise(white=1e-3),
        "white 1 mm, 0.3 % flying pixels": Noise(white=1e-3, flying=3e-3),
        "white 1 mm, 1 % flying pixels": Noise(white=1e-3, flying=1e-2),
        "correlated, 8 frames": CORRELATED,
    }
    for press in CYLINDERS[3:]:
        view = seen(press)
        top = top_of(view)
        for name, noise in flying.items():
            found, refused = [], 0
            for seed in range(frames):
                points, valid = cloud(observe(view, noise, seed))
                try:
                    height = track_height(points, valid, classify(points, valid).labels)
                    found.append((height.value - top, height.sd))
                except NoAnswer:
                    refused += 1
            error, stated = np.array(found).T
            bound = noise.white / np.sqrt(binary_fill_holes(view.touching).sum())
            share = f"{np.sqrt(np.mean(error**2)) / bound:9.2f}" if bound else f"{'-':>9s}"
            body = press.indenter
            assert isinstance(body, Cylinder)
            words = f"{body.diameter * MM:g} mm, stretch {press.stretch * MM:g}, depth {press.depth * MM:g}"
            yield (
                f"{words:30s} {name:34s} {error.mean() * MM:+8.4f} {error.std() * MM:7.4f} {share}"
                f" {stated.mean() / error.std():9.2f} {refused}"
            )


def top_of(view: SheetView) -> float:
    """Return the height of the middle of the face, m, which is what a height away from the rim means."""
    points, _ = cloud(observe(view, CLEAN, 0))
    v, u = np.nonzero(view.touching)
    middle = np.zeros(view.touching.shape, dtype=bool)
    middle[int(np.mean(v)) - 6 : int(np.mean(v)) + 7, int(np.mean(u)) - 6 : int(np.mean(u)) + 7] = True
    return float(np.median(points[..., 2][middle]))


def detection_rows(frames: int) -> Iterator[str]:
    yield "contact detection without contact: frames called contact that were not before, of frames with a decision"
    yield f"{'noise':34s} {'asked':>8s} {'alarms':>7s} {'frames':>7s} {'rate':>9s} {'ms':>6s}"
    noises = {"white 0.2 mm": (0.2e-3, 0.0), "correlated 1 mm, AR(1) 0.6": (0.0, 1e-3), "both": (0.2e-3, 0.3e-3)}
    for name, (white, correlated) in noises.items():
        for rate in (1e-2, 1e-3):
            alarms = decided = 0
            times = []
            for run in range(max(4, frames // 4)):
                detector, was = ContactDetector(false_alarms=rate), False
                for image in still(white, correlated, 150, run):
                    began = time.process_time()
                    now = detector.update(image)
                    times.append(MM * (time.process_time() - began))
                    alarms += now and not was
                    decided += detector.ready
                    was = now
            yield f"{name:34s} {rate:8.0e} {alarms:7d} {decided:7d} {alarms / decided:9.1e} {np.median(times):6.2f}"


def still(white: float, correlated: float, count: int, seed: int) -> Iterator[Any]:
    """Yield depth images of a flat membrane, with noise that is white and noise that pixels and frames share."""
    from scipy.ndimage import gaussian_filter

    rng = np.random.default_rng(seed)
    shape, state = (120, 160), None
    for _ in range(count):
        fresh = gaussian_filter(rng.standard_normal(shape), 3.0, mode="wrap") * 6.0 * np.sqrt(np.pi) * correlated
        state = fresh if state is None else 0.6 * state + 0.8 * fresh
        yield noisy(PLANE_DISTANCE + state, white, rng)


def main() -> None:
    import cv2

    cv2.setNumThreads(1)  # else its threads wait for each other on time that is counted
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    for rows in (
        speed_rows(),
        class_rows(frames),
        confidence_rows(frames),
        height_rows(frames),
        detection_rows(frames),
    ):
        for row in rows:
            print(row, flush=True)
        print()


if __name__ == "__main__":
    main()
