"""The twin's depth camera: error of its images against CPU time, over the pitch of the surface's grid."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy import peers
from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import CPU_MS, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind

__all__ = ["DOMAIN"]

ABOUT = """\
Presses of the sheet by spheres, a cylinder and a cube at stretch 30 and 60 mm, 5 and 10 mm deep, seen from 200 mm on 213 x 333 pixels,
with the table beside them. A case is a press; its error is the root mean square over the pixels that show the sheet, against cubic
splines through a grid of 0.35 mm, whose crossing with each ray is solved to the last digit. The reference's own error is its change from
a grid of 0.5 mm, divided as befits an error of fourth order. A variant is the pitch of the grid through which the renderer sees the
surface; time is of one image."""

KINDS = {"depth": Kind("um", 1e6, "m")}
OMITTED = {
    "noise": "each of the camera's errors is as its preset says, and takes 0.1 to 3 ms of an image; `python benchmarks/camera.py` measures both",
    "height and size by perception": "at a pitch of 0.7 mm they move by less than by a tenth of the noise; the same benchmark has them",
    "folded membranes, distorting lenses": "rare; a depth buffer and the lens take some ms more, at the same error",
}


def take(found: DomainSummaries) -> str:
    """Say which pitch to take."""
    one = found.cheapest("depth", CPU_MS, 1e-6, ("renderer",))
    default = found.default("depth", CPU_MS)
    also = ", which also is the cheapest within 1 um" if one == default else f"; for 1 um take {one}"
    return f"So take the default pitch, {default}, whose error is far below any camera's noise{also}."


def warm() -> None:
    """Render one press coarsely."""
    from stretch_bt.accuracy.camera import rendering

    rendering.warm()


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every press at every pitch."""
    from stretch_bt.accuracy.camera import rendering

    yield from rendering.jobs()


PANELS = (Panel("depth", CPU_MS, (), "error of a depth image"),)
DOMAIN = Domain(ABOUT, KINDS, PANELS, take, OMITTED, warm, jobs, peers.names(("open3d_rays",)))
