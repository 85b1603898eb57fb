"""Errors of fused clouds and of the dimensions measured in them; run as `python benchmarks/perception_objects.py [draws]`."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.objects import OBJECTS, PLACE, any_pose, contact
from stretch_bt.perception import fuse_contact, measure_object

Array = npt.NDArray[np.float64]
MM = 1e3


def dimension_rows(draws: int) -> Iterator[str]:
    yield "dimensions, edges rounded by 2 mm: error and its spread, stated deviation, shortness stated, mm"
    yield "noise mm  object            axis     how                      error  spread  stated   short     ms"
    for noise in (0.05e-3, 0.3e-3, 1e-3):
        for name, (truth, make) in OBJECTS.items():
            found, times = [], []
            for seed in range(draws):
                rng = np.random.default_rng(seed)
                cloud = make(noise, rng, rng.uniform(-1.5, 1.5))
                start = time.process_time()
                found.append(measure_object(cloud))
                times.append(1e3 * (time.process_time() - start))
            for k, axis in enumerate(("length", "width", "height")):
                yield f"{noise * MM:8.2f}  {name:16s}  {axis:7s}  {_axis_row(found, k, truth[k])}  {np.median(times):5.0f}"


def _axis_row(found: list[Any], k: int, truth: float) -> str:
    how = " ".join(f"{name} {count}" for name, count in sorted(Counter(d.how[k] for d in found).items()))
    error = np.array([d.lengths[k] - truth for d in found]) * MM
    stated, short = (np.mean([getattr(d, what)[k] for d in found]) * MM for what in ("sd", "short"))
    return f"{how:22s}  {error.mean():+6.3f}  {error.std():6.3f}  {stated:6.3f}  {short:6.3f}"


def fusion_rows(draws: int) -> Iterator[str]:
    yield "fusion of a tilted plane seen from many poses, 0.3 % flying pixels: rms and stated noise along z, mm"
    yield "noise mm  contacts  seen    points  rms     stated  largest  disagreement  ms a contact"
    for noise in (0.05e-3, 0.3e-3, 1e-3):
        rng = np.random.default_rng(0)
        cloud, times = None, []
        for _ in range(draws):
            seen = contact(any_pose(rng), _plane, noise, rng, flying=3e-3)
            start = time.process_time()
            cloud = fuse_contact(seen, cloud)
            times.append(1e3 * (time.process_time() - start))
        assert cloud is not None
        error = cloud.points[:, 2] - _plane(cloud.points[:, 0], cloud.points[:, 1])
        for count in np.unique(np.linspace(1, draws, 4).astype(int)):
            these = cloud.seen == count
            if these.any():
                rms, stated = np.sqrt(np.mean(error[these] ** 2)), np.sqrt(np.mean(cloud.noise[these] ** 2))
                yield (
                    f"{noise * MM:8.2f}  {draws:8d}  {count:4d}  {these.sum():8d}  {rms * MM:.4f}  {stated * MM:.4f}"
                    f"  {np.abs(error[these]).max() * MM:7.3f}  {cloud.disagreement:12.2f}  {np.median(times):6.0f}"
                )


def _plane(x: Array, y: Array) -> Array:
    return np.asarray(0.03 + 0.3 * (x - PLACE[0]) + 0.0 * y)


def main() -> None:
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    for rows in (fusion_rows, dimension_rows):
        for line in rows(max(draws, 2)):
            print(line, flush=True)
        print()


if __name__ == "__main__":
    main()
