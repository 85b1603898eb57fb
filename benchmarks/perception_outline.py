"""Circularity by each method beside the truth, and its cost; run as `python benchmarks/perception_outline.py [draws]`."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from stretch_bt.accuracy.perception.outlines import PITCH, jittered, mask, outline, true_area, true_circularity
from stretch_bt.perception import circularity, outline_of

HEADINGS = "size mm  shape      method       noise       truth    mean error  largest  spread  stated sd  ms"
SIZES = (25e-3, 40e-3, 60e-3)


def timed(function: Callable[..., Any], *args: Any, **options: Any) -> tuple[Any, float]:
    """Return the result and the CPU time, ms."""
    start = time.process_time()
    result = function(*args, **options)
    return result, 1e3 * (time.process_time() - start)


def row(size: float, shape: str, method: str, noise: str, found: list[tuple[float, float, float]]) -> str:
    value, stated, ms = np.array(found).T
    error = value - true_circularity(shape)
    return (
        f"{size * 1e3:7.0f}  {shape:9s}  {method:11s}  {noise:10s}  {true_circularity(shape):.4f}  {error.mean():+10.4f}"
        f"  {np.abs(error).max():7.4f}  {error.std():6.4f}  {stated.mean():9.4f}  {np.median(ms):4.1f}"
    )


def jitter_rows(draws: int) -> Iterator[str]:
    yield f"outlines with a vertex every {PITCH * 1e3:.1f} mm, each moved along the normal by white noise"
    yield HEADINGS
    for size in SIZES:
        for shape in ("disc", "oval", "square", "triangle"):
            for method in ("contour", "low_pass", "pixel_chain"):
                for pixels in (0.0, 0.5, 1.0, 2.0):
                    found = []
                    for seed in range(draws):
                        vertices = jittered(outline(shape, size), pixels * PITCH, seed)
                        value, ms = timed(circularity, vertices, method=method)
                        found.append((float(value), value.sd, ms))
                    yield row(size, shape, method, f"{pixels:.1f} px", found)


def mask_rows(draws: int) -> Iterator[str]:
    yield "masks at random places and angles; pixels at the border change sides with a probability"
    yield HEADINGS + "  area error  spread  stated sd"
    for size in SIZES:
        for shape in ("disc", "oval", "square"):
            for flips in (0.0, 0.25, 0.5):
                found, areas = [], []
                for seed in range(draws):
                    region = mask(shape, size, seed=seed, flips=flips)
                    traced, ms = timed(outline_of, region, PITCH)
                    measured, more = timed(traced.roundness)
                    found.append((measured.circularity, measured.circularity_sd, ms + more))
                    areas.append((traced.area, traced.area_sd))
                area, stated = np.array(areas).T / true_area(shape, size)
                yield (
                    row(size, shape, "contour", f"flips {flips:.2f}", found)
                    + f"  {area.mean() - 1:+10.4f}  {area.std():6.4f}  {stated.mean():9.4f}"
                )


def main() -> None:
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    for rows in (jitter_rows, mask_rows):
        for line in rows(max(draws, 2)):
            print(line, flush=True)
        print()


if __name__ == "__main__":
    main()
