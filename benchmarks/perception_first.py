"""Accuracy beside CPU time of the perception functions; run as `python benchmarks/perception_first.py [draws]`."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from perception_surfaces import (
    PLANE_DISTANCE,
    camera,
    cap,
    curvature_bound,
    disc_press,
    distance_from_axis,
    noisy,
    render,
    sphere_press,
)

from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.perception import (
    ContactDetector,
    deproject,
    find_contact,
    fit_sphere,
    segment,
    to_membrane,
    track_height,
)

MM = 1e3


def timed(function: Callable[..., Any], *args: Any, **options: Any) -> tuple[Any, float]:
    """Return the result, or None where there is no answer, and the CPU time, ms."""
    start = time.process_time()
    try:
        result = function(*args, **options)
    except NoAnswer:
        result = None
    return result, 1e3 * (time.process_time() - start)


def with_outliers(points: Any, share: float, rng: np.random.Generator) -> Any:
    """Move a share of the points by 3 to 20 mm, to either side."""
    hit = rng.random(len(points)) < share
    points[hit, 2] += rng.uniform(3e-3, 20e-3, hit.sum()) * rng.choice([-1.0, 1.0], hit.sum())
    return points


def sphere_rows(draws: int) -> Iterator[str]:
    yield "sphere fit, true mask, pitch 0.42 mm: curvature against its Cramer-Rao bound (all points)"
    yield "noise mm  outliers  R mm  cap deg      n  sd/bound  bias/bound  stated/sd  refused  ms"
    for noise, share, radius, angle in (
        (n, o, r, a)
        for n in (0.3e-3, 1e-3)
        for o in (0.0, 0.3)
        for r in (5e-3, 15e-3, 30e-3)
        for a in (15, 20, 30, 45, 60)
    ):
        rng = np.random.default_rng(0)
        points = cap(radius, np.radians(angle))
        bound = curvature_bound(points, radius, noise)
        if 1.0 / radius < 6.0 * bound:
            continue
        fits, times = [], []
        for _ in range(draws):
            seen = points + np.column_stack([np.zeros((len(points), 2)), rng.normal(0.0, noise, len(points))])
            fit, ms = timed(fit_sphere, with_outliers(seen, share, rng))
            times.append(ms)
            if fit is not None:
                fits.append((fit.curvature, fit.curvature_sd))
        value, stated = np.array(fits).T
        yield (
            f"{noise * MM:8.1f}  {share:8.1f}  {radius * MM:4.0f}  {angle:7d}  {len(points):5d}"
            f"  {value.std() / bound:8.2f}  {(value.mean() - 1 / radius) / bound:+10.2f}  {stated.mean() / value.std():9.2f}"
            f"  {1 - len(fits) / draws:7.3f}  {np.median(times):.2f}"
        )


def end_to_end_rows(draws: int) -> Iterator[str]:
    yield "sphere end to end (segmented here), analytic cap and skirt, 333 x 213 px, quantum 0.125 mm, 1 % dropouts"
    yield "noise mm  R mm  cap deg  depth mm   IoU  median R/R0  sd R/R0  refused  find ms  fit ms"
    lens = camera()
    for noise in (0.3e-3, 1e-3):
        for radius, angle in ((r, a) for r in (5e-3, 10e-3, 15e-3, 30e-3) for a in (20, 30, 45)):
            depth = render(sphere_press(radius, np.radians(angle)), lens)
            if PLANE_DISTANCE - depth.min() > 25e-3:
                continue
            truth = distance_from_axis(depth, lens) < radius * np.sin(np.radians(angle))
            yield end_to_end_row(depth, truth, noise, radius, angle, draws)


def end_to_end_row(depth: Any, truth: Any, noise: float, radius: float, angle: float, draws: int) -> str:
    rng = np.random.default_rng(0)
    ratios, overlaps, find, fit_ms = [], [], [], []
    for _ in range(draws):
        raw = np.round(noisy(depth, noise, rng) / 0.125e-3).astype(np.uint16)
        frame = DepthFrame(raw, 0.125e-3, camera(), 0.0, 0, PLANE_DISTANCE)
        contact, ms = timed(find_contact, frame)
        find.append(ms)
        if contact is None:
            continue
        touching = contact.labels == 2
        overlaps.append((touching & truth).sum() / (touching | (truth & (contact.labels != 255))).sum())
        fit, ms = timed(fit_sphere, contact.points, rays=contact.rays)
        fit_ms.append(ms)
        if fit is not None:
            ratios.append(fit.radius / radius)
    return (
        f"{noise * MM:8.1f}  {radius * MM:4.0f}  {angle:7d}  {(PLANE_DISTANCE - depth.min()) * MM:8.1f}"
        f"  {np.mean(overlaps):4.2f}  {np.median(ratios):11.3f}  {np.std(ratios):7.3f}  {1 - len(ratios) / draws:7.3f}"
        f"  {np.median(find):7.1f}  {np.median(fit_ms):6.2f}"
    )


def disc_rows(draws: int) -> Iterator[str]:
    yield "flat discs: the label 2 as a disc, and the height of the face"
    yield "noise mm  D mm  depth mm   IoU  D of area  height error mm  stated sd mm  segment ms  height ms"
    lens = camera()
    for noise, diameter, depth in (
        (n, d, z) for n in (0.2e-3, 0.5e-3) for d in (10e-3, 20e-3, 30e-3) for z in (5e-3, 10e-3)
    ):
        rng = np.random.default_rng(0)
        image = render(disc_press(diameter / 2, depth), lens)
        truth = distance_from_axis(image, lens) < diameter / 2
        rows = []
        for _ in range(draws):
            points, valid = deproject(noisy(image, noise, rng), lens)
            points = to_membrane(points, PLANE_DISTANCE)
            labels, ms = timed(segment, points, valid)
            touching = labels == 2
            height, height_ms = timed(track_height, points, valid, labels)
            area = touching.sum() * ((PLANE_DISTANCE - depth) / lens.fx) ** 2 / 0.99
            overlap = (touching & truth).sum() / (touching | (truth & valid)).sum()
            rows.append((overlap, 2 * np.sqrt(area / np.pi), height.value - depth, height.sd, ms, height_ms))
        iou, wide, error, sd, ms, height_ms = np.array(rows).T
        yield (
            f"{noise * MM:8.1f}  {diameter * MM:4.0f}  {depth * MM:8.0f}  {iou.mean():4.2f}  {wide.mean() * MM:9.1f}"
            f"  {error.mean() * MM:+7.3f}+-{error.std() * MM:5.3f}  {sd.mean() * MM:12.3f}  {np.median(ms):10.1f}"
            f"  {np.median(height_ms):9.2f}"
        )


def detection_rows(draws: int) -> Iterator[str]:
    yield "contact detection: runs of 100 frames without contact, white noise 0.2 mm, quantum 0.125 mm"
    lens = camera(100, 150)
    plane = np.full((lens.height, lens.width), PLANE_DISTANCE)
    for rate in (1e-2, 1e-3):
        rng = np.random.default_rng(0)
        alarms, frames, times = 0, 0, []
        for _ in range(max(1, draws // 5)):
            detector = ContactDetector(false_alarms=rate)
            for _ in range(100):
                called, ms = timed(detector.update, noisy(plane, 0.2e-3, rng))
                times.append(ms)
                alarms += called
                frames += detector.ready
        yield f"asked {rate:.0e} a frame: {alarms} of {frames}, {np.median(times):.2f} ms a frame of 150 x 100 px"


def main() -> None:
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    for rows, count in (
        (sphere_rows, draws),
        (end_to_end_rows, draws // 5),
        (disc_rows, draws // 5),
        (detection_rows, draws),
    ):
        for row in rows(max(count, 2)):
            print(row, flush=True)
        print()


if __name__ == "__main__":
    main()
