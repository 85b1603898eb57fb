"""One press of the sheet by a rigid body, as a depth camera 200 mm above the membrane would see it without noise."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, fields, is_dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.render import render
from stretch_bt.compiled import cache_folder
from stretch_bt.frames import Intrinsics
from stretch_bt.simulation import membrane
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["CAMERA", "PLANE_DISTANCE", "BodyPress", "SheetView", "seen", "seen_of"]

PLANE_DISTANCE = 0.2
CAMERA = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333)  # a crop of the sensor that holds the membrane


@dataclass(frozen=True, slots=True)
class BodyPress:
    """A rigid body, the stretch and the depth of the press, m, the place (x, y), m, and the smallest elements, m."""

    indenter: Indenter | Several
    stretch: float
    depth: float
    at: tuple[float, float] = (0.0, 0.0)
    mesh: float = 1e-3


@dataclass(frozen=True, slots=True)
class SheetView:
    """The depth (h, w) float32, m, 0 where the sheet is not seen; where it touches (h, w); and the force, N."""

    press: BodyPress
    depth: npt.NDArray[np.float32]
    touching: npt.NDArray[np.bool_]
    force: float

    @property
    def area(self) -> float:
        """Area, m^2, of the contact seen along z: each pixel's share grows with its squared depth."""
        return float((self.depth[self.touching].astype(np.float64) ** 2).sum()) / (CAMERA.fx * CAMERA.fy)

    @property
    def radius(self) -> float:
        """Radius, m, of the disc with the area of the contact seen along z."""
        return math.sqrt(self.area / math.pi)


def seen(wanted: BodyPress) -> SheetView:
    """Return the camera's view of a press; solved presses are kept between runs.

    Raises
    ------
    NoEquilibrium
        The sheet has none.
    """
    file = _file(wanted)
    if file is not None and file.exists():
        with np.load(file) as kept:
            return SheetView(wanted, kept["depth"], kept["touching"], float(kept["force"]))
    found = _solved(wanted)
    if file is not None:
        part = file.with_name(f"{file.stem}.{np.random.default_rng().integers(1 << 40)}.npz")
        np.savez_compressed(part, depth=found.depth, touching=found.touching, force=found.force)
        part.replace(file)
    return found


def _solved(wanted: BodyPress) -> SheetView:
    settings = Settings(mesh=wanted.mesh, growth=1.4, budget=3000)
    solved = press(wanted.indenter, wanted.stretch, wanted.depth, at=wanted.at, settings=settings).detail
    return seen_of(wanted, solved)


def seen_of(wanted: BodyPress, solved: object) -> SheetView:
    """Return the camera's view of a press that the sheet solved."""
    assert isinstance(solved, SheetPress)
    depth, points = render(solved.shape, CAMERA, PLANE_DISTANCE)
    visible = np.isfinite(points[..., 2])
    touching = np.zeros(depth.shape, bool)
    touching[visible] = solved.touches(points[visible])
    return SheetView(wanted, depth.astype(np.float32), touching, float(solved.force[2]))


def _file(wanted: BodyPress) -> Path | None:
    folder = cache_folder()
    if folder is None:
        return None
    name = hashlib.sha256(f"{_whole(wanted)} {_sources()}".encode()).hexdigest()[:24]
    kept = folder.parent / "views"  # a kernel that no view depends on may change
    kept.mkdir(exist_ok=True)
    return kept / f"{name}.npz"


def _whole(value: object) -> str:
    """Return all numbers that define a press or a body; the repr of a body of many numbers shows few of them."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_whole, value))})"
    if is_dataclass(value):
        return f"{type(value).__name__}({', '.join(_whole(getattr(value, field.name)) for field in fields(value))})"
    return repr(value)


@lru_cache(maxsize=1)
def _sources() -> str:
    """Return a digest of all that a view depends on, so that none outlives a change."""
    digest = hashlib.sha256()
    here = Path(__file__).parent
    for file in sorted([*Path(membrane.__path__[0]).rglob("*.py"), here / "render.py", here / "view.py"]):
        digest.update(file.read_bytes())
    return digest.hexdigest()
