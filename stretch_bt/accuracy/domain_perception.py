"""Perception: each step against the truth of the sheet solver, beside its CPU time."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from itertools import groupby, zip_longest
from pkgutil import iter_modules

from stretch_bt.accuracy import peers
from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import CPU_MS, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind, Setting

__all__ = ["DOMAIN", "by_case"]

ABOUT = """\
Presses of the finite-strain sheet, seen by a camera 200 mm above it at 0.42 mm a pixel: 213 x 333 pixels, counts of 0.125 mm, 1 % of
the pixels without a value. A case is a press with one kind of noise, white of 0.3 to 1 mm or smooth over 3 pixels; its error is the root
mean square over 40 frames (4 with `--quick`), its time the median of the calls. The truth is the sheet that was rendered, to a few
micrometres. `Cramer-Rao bound` is the least error of any unbiased estimator under that noise; of a frame that is refused the row says how
many were. The prior behind a contact's size has seen other presses of the same sheet."""

KINDS = {
    "height": Kind("um", 1e6, "m"),
    "radius": Kind("%", 100.0),
    "diameter": Kind("mm", 1e3, "m"),
    "circularity": Kind("1", 1.0),
    "overlap": Kind("%", 100.0),
    "normal": Kind("deg", 57.29578, "rad"),
    "curvature": Kind("1/m", 1.0, "1/m"),
}
TITLES = {
    "height": "error of the height of the top",
    "radius": "error of the curvature of a sphere",
    "diameter": "error of the diameter of a flat contact",
    "circularity": "error of the circularity of an outline",
    "overlap": "part of the pixels in contact that is missed or made up",
    "normal": "error of the normals",
}
OMITTED = {
    "the curvature map": "it follows the normals, whose diagram ranks the same kernels; the rows have it",
    "clouds, dimensions and rectangles": "they are measured as tasks, in the part reconstruction and under [figures](../figures.md#perception)",
    "each noise by itself": "a bar spans the noises; the rows have each",
}
PEERS = peers.names(("pyransac3d_sphere", "open3d_normals"))


def take(found: DomainSummaries) -> str:
    """Say which settings to take."""
    return (
        f"So take the defaults: of a height {found.default('height', CPU_MS)}, of a sphere {found.default('radius', CPU_MS)}, "
        f"of a flat contact {found.default('diameter', CPU_MS)}, of an outline {found.default('circularity', CPU_MS)}. "
        f"Of the pixels in contact the default finds the edge to some pixels: {found.default('overlap', CPU_MS)} under these noises. "
        "`true contact` and `true labels` are no settings. "
        f"{found.setting(Setting('sphere fit, true contact', 'all points'), 'radius', CPU_MS)} errs about as much as our own, which reads "
        "the skirt too: to know a sphere's contact gains little. Nor is the contact what a height lacks: it errs more on true labels, "
        f"{found.setting(Setting('height', 'true labels'), 'height', CPU_MS)}. At stretch 0 the sheet "
        "touches a flat end only around its rim, so that few pixels are in contact; our labels take in the free middle too, which is at "
        "the same height. Of most other presses both err alike."
    )


def warm() -> None:
    """Take each step with each setting on one frame, but for other programs, whose medians leave a first call out."""
    for found in by_case(1):
        for job in (job for job in found[0] if job.setting.series not in PEERS):
            job.run()


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every step with every setting, the first case of each step first; with `quick` on fewer frames."""
    from stretch_bt.accuracy.perception.measure import FULL, QUICK

    for cases in zip_longest(*by_case(QUICK if quick else FULL), fillvalue=()):
        for case in cases:
            yield from case


def by_case(frames: int) -> list[list[list[Job]]]:
    """Return the jobs of each step, grouped by case."""
    from stretch_bt.accuracy.perception import steps

    modules = [import_module(m.name) for m in iter_modules(steps.__path__, f"{steps.__name__}.")]
    return [[[*group] for _, group in groupby(m.jobs(frames), key=lambda job: job.case)] for m in modules]


DOMAIN = Domain(
    ABOUT,
    KINDS,
    tuple(Panel(kind, CPU_MS, (), title) for kind, title in TITLES.items()),
    take,
    OMITTED,
    warm,
    jobs,
    PEERS,
)
