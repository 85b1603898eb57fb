"""Height of the object's top, on labels that are right and on our own."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache, partial
from itertools import product
from typing import Any

import numpy as np

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.perception.measure import (
    CYLINDERS,
    NOISES,
    SPHERES,
    bound_job,
    cloud,
    clouds,
    job,
    view_of,
    words,
)
from stretch_bt.accuracy.perception.noise import CLEAN
from stretch_bt.accuracy.perception.view import BodyPress
from stretch_bt.accuracy.points import Setting
from stretch_bt.perception import segment, track_height
from stretch_bt.perception.types import CONTACT, INVALID, UNDEFORMED
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.units import Estimate

__all__ = ["jobs"]

_RENDERED = 3e-6  # m, that the rendered sheet is off


def jobs(frames: int) -> Iterator[Job]:
    """Yield the root mean square error, m; for flat tops beside the Cramer-Rao bound of white noise."""
    for press, (name, noise) in product(CYLINDERS + SPHERES, NOISES.items()):
        case = f"{words(press)}, {name}"
        if noise.white > 0.0 and isinstance(press.indenter, Cylinder):
            yield bound_job(case, frames, "height", partial(_bound, press, noise.white))
        for own in (True, False):
            yield job(
                case,
                Setting("height", "our labels" if own else "true labels"),
                "height",
                frames,
                partial(_height, press, own),
                partial(_off, press),
                partial(clouds, press, noise, frames),
                seconds=0.05,
                default=own,
                reference_error=_RENDERED,
            )


def _height(press: BodyPress, own: bool, points_: Any, valid: Any) -> Estimate:
    return track_height(points_, valid, segment(points_, valid) if own else _true_labels(press, valid))


def _off(press: BodyPress, found: Estimate) -> float:
    return float(found.value) - _top(press)


def _true_labels(press: BodyPress, valid: Any) -> Any:
    return np.where(valid, np.where(view_of(press).touching, CONTACT, UNDEFORMED), INVALID).astype(np.uint8)


@lru_cache(maxsize=16)
def _top(press: BodyPress) -> float:
    """Return the height of the sheet over the top, m: its contact is a little softer than a hard one."""
    view = view_of(press)
    z = cloud(view, CLEAN, 0)[0][..., 2][view.touching]
    return float(np.median(z)) if isinstance(press.indenter, Cylinder) else float(z.max())


def _bound(press: BodyPress, noise: float) -> float:
    return noise / float(np.sqrt(view_of(press).touching.sum()))
