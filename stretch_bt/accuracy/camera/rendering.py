"""Depth images of pressed sheets by the twin's renderer, against rays that are followed on cubic splines."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.peers import guarded, open3d_rays
from stretch_bt.accuracy.perception.render import render
from stretch_bt.accuracy.points import REFERENCE, Answer, Setting
from stretch_bt.frames import Intrinsics
from stretch_bt.simulation.camera.renderer import DepthRenderer
from stretch_bt.simulation.camera.skin import Grid, Plane
from stretch_bt.simulation.fidelity.sheet import PITCH
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.membrane.sheet.result import Shape, SheetPress

__all__ = ["CROP", "DISTANCE", "PITCHES", "TABLE", "jobs", "points_of", "solved", "timed", "warm"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[Any]

DISTANCE = 0.2  # m, of the flat membrane from the camera
CROP = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333)
TABLE = Plane((0.0, 0.0, 1.0), -0.03)
PITCHES = (2e-3, 1.4e-3, 1e-3, PITCH, 0.5e-3, 0.35e-3)  # m
_AT = (0.002, -0.003)  # m, off the middle, as most presses are
_REFERENCE = (0.35e-3, 0.5e-3)  # m, the pitches of the reference, and of the one that gives its own error
_ORDER = 4  # of the error of cubic splines
_BEYOND = 0.22  # m; farther pixels show the table, whose edge is none of the surface's
_CALLS = 9
_PEER_PITCHES = (1.4e-3, PITCH, 0.35e-3)


class RenderedPress(NamedTuple):
    """A press that is seen: lengths in m."""

    name: str
    body: Indenter
    stretch: float
    depth: float

    def __str__(self) -> str:
        return f"{self.name}, stretch {1e3 * self.stretch:g} mm, depth {1e3 * self.depth:g} mm"


BODIES: dict[str, Indenter] = {
    "sphere 60 mm": Sphere(0.06),
    "cylinder 20 mm": Cylinder(0.02),
    "sphere 20 mm": Sphere(0.02),
    "sphere 30 mm": Sphere(0.03),
    "cube 20 mm": Cube(0.02),
}
VIEWS = [
    RenderedPress(name, body, *xz)
    for xz, (name, body) in product(product((0.03, 0.06), (0.010, 0.005)), BODIES.items())
]


def warm() -> None:
    """Render one press coarsely, by the renderer and by rays."""
    shape = solved(BODIES["cylinder 20 mm"], 0.03, 0.004, mesh=3e-3).shape
    DepthRenderer(CROP, DISTANCE).render(Grid(points_of(shape, 2e-3)), TABLE)
    render(shape, CROP, DISTANCE, 2e-3)


def jobs() -> Iterator[Job]:
    """Yield each press seen at each pitch, by the renderer and by Open3D."""
    for view in VIEWS:
        case = str(view)
        own = Setting("reference", "rays on cubic splines")
        yield Job(case, own, "depth", 3.0, partial(_own, view), group=case, once=True)
        for pitch in PITCHES:
            setting = Setting("renderer", f"{1e3 * pitch:g} mm")
            yield Job(case, setting, "depth", 0.2, partial(_rendered, view, pitch), default=pitch == PITCH, group=case)
        for pitch in _PEER_PITCHES:
            setting = Setting(open3d_rays.NAME, f"triangles of {1e3 * pitch:g} mm")
            job = Job(case, setting, "depth", 0.5, partial(_rays, view, pitch), group=case)
            yield guarded("open3d_rays", job)


def solved(body: Indenter, stretch: float, depth: float, mesh: float = 1e-3) -> SheetPress:
    """Return a press a little off the middle."""
    detail = press(body, stretch, depth, at=_AT, mesh=mesh).detail
    assert isinstance(detail, SheetPress)
    return detail


def points_of(shape: Shape, pitch: float) -> Array:
    """Return points (rows, columns, 3), m, of a sheet about every `pitch`, m, of the unstretched one."""
    columns, rows = (round((a.breaks[-1] - a.breaks[0]) * shape.unit / pitch) + 1 for a in (shape.mesh.x, shape.mesh.y))
    return np.ascontiguousarray(shape.points(columns, rows))


def timed(call: Callable[[], Any], count: int = _CALLS) -> tuple[Any, float]:
    """Return the answer of a call, and the median CPU time, s, of several."""
    spent = []
    for _ in range(count):
        began = time.process_time()
        found = call()
        spent.append(time.process_time() - began)
    return found, float(np.median(spent))


class _Right(NamedTuple):
    depth: Image  # (h, w), m, 0 where the sheet is not seen
    own: float  # m, rms, that it is off itself
    seconds: float


@lru_cache(maxsize=2)
def _shape(view: RenderedPress) -> Shape:
    return solved(view.body, view.stretch, view.depth).shape


@lru_cache(maxsize=2)
def _right(view: RenderedPress) -> _Right:
    (fine, seconds), (coarse, _) = (
        timed(lambda p=pitch: render(_shape(view), CROP, DISTANCE, p)[0], 1)  # type: ignore[misc]
        for pitch in _REFERENCE
    )
    change = _rms(coarse, fine)
    return _Right(fine, change / ((_REFERENCE[1] / _REFERENCE[0]) ** _ORDER - 1), seconds)


def _rms(depth: Image, right: Image) -> float:
    both = (right > 0) & (depth > 0) & (depth < _BEYOND)
    return float(np.sqrt(np.mean((depth[both] - right[both]) ** 2)))


def _own(view: RenderedPress) -> list[Answer]:
    right = _right(view)
    return [Answer("depth", right.own, right.seconds, right.own, status=REFERENCE)]


def _rendered(view: RenderedPress, pitch: float) -> list[Answer]:
    right, points = _right(view), points_of(_shape(view), pitch)
    renderer = DepthRenderer(CROP, DISTANCE)
    depth, seconds = timed(lambda: renderer.render(Grid(points), TABLE))
    return [Answer("depth", _rms(depth, right.depth), seconds, right.own)]


def _rays(view: RenderedPress, pitch: float) -> list[Answer]:
    right, points = _right(view), points_of(_shape(view), pitch)
    depth, seconds = timed(lambda: open3d_rays.depth(points, CROP, DISTANCE))
    return [Answer("depth", _rms(depth, right.depth), seconds, right.own)]
