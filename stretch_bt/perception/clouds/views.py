"""From frames of a press to what a map and a cloud take."""

from __future__ import annotations

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.seen import Array, CellView
from stretch_bt.perception.deprojection import points_of, to_world, view_rays
from stretch_bt.perception.noise import pixel_noise
from stretch_bt.perception.types import CONTACT, DEFORMED, INVALID, Contact

__all__ = ["contact_of", "surface_of"]

LEAST_NOISE = 5e-5  # m; a fit takes no point to be better
FEWEST = 40  # points that are worth adding


def surface_of(frame: DepthFrame) -> Array:
    """Return the points of the membrane (h, w, 3), m, membrane frame, NaN where nothing is valid.

    Raises
    ------
    InvalidInput
        The frame does not say how far the flat membrane is.
    """
    if frame.plane_distance is None:
        raise InvalidInput(
            "the points of a membrane need a frame with plane_distance, the distance to the flat membrane"
        )
    points, valid = points_of(frame, None, -1.0, frame.plane_distance)
    return np.where(valid[..., None], points, np.nan)


def contact_of(frame: DepthFrame, surface: Array, view: CellView, relief: Relief) -> Contact | None:
    """Return the points of a frame that lie in cells in which the membrane touched, None where they are too few.

    Parameters
    ----------
    frame : DepthFrame
        With the pose of the hand.
    surface : (h, w, 3) float, m, membrane frame
        Its points.
    view : View
        What the press shows.
    relief : Relief
        The map with the view in it; points that it no longer holds are left out.
    """
    if frame.pose is None or frame.plane_distance is None:
        raise InvalidInput("a contact in the world needs a frame with pose and plane_distance")
    known = np.asarray(np.isfinite(surface).all(axis=2))
    seen = surface.reshape(-1, 3)[known.ravel()]
    world = to_world(seen, frame.pose)
    touched = np.zeros(relief.ceiling.shape, dtype=bool)
    i, j = (view.cells - relief.origin).T
    touched[i, j] = view.touched
    on = relief.holds(world) & relief.at(touched, world[:, 0], world[:, 1], False)
    if on.sum() < FEWEST:
        return None
    labels = np.full(known.shape, INVALID, np.uint8)
    labels[known] = np.where(on, CONTACT, DEFORMED)
    points = seen[on]
    return Contact(
        points=points,
        rays=view_rays(points, (0.0, 0.0, frame.plane_distance)),
        labels=labels,
        noise=_noise(frame),
        hand_height=frame.hand_height,
        stretch=frame.stretch,
        time=frame.time,
        surface=surface,
        confidence=np.asarray(known, dtype=np.float32),
        pose=frame.pose,
    )


def _noise(frame: DepthFrame) -> float:
    try:
        return max(float(np.median(pixel_noise(frame).sd)), LEAST_NOISE)
    except IllConditioned:
        return LEAST_NOISE
