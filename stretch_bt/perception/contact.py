"""From one depth frame to the contact: deproject, segment, collect the points."""

from __future__ import annotations

import numpy as np

from stretch_bt.arguments import check_kind
from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.counts import check_evened, count_of, even_out
from stretch_bt.perception.deprojection import points_of
from stretch_bt.perception.segmentation import Rule, classify
from stretch_bt.perception.types import CONTACT, FRAME, Contact

__all__ = ["find_contact"]


def find_contact(frame: DepthFrame, *, rule: Rule = "mean") -> Contact:
    """Return the contact that a frame shows, in the membrane frame.

    Raises
    ------
    NoContact
        No pixel is in contact, or none is valid.
    IllConditioned
        The frame shows no membrane in its plane, or is too noisy, or depth comes in counts too coarse for its noise.
    InvalidInput
        The frame does not say how far the camera is from the flat membrane.
    """
    from stretch_bt.perception.contact_kernel import fill_touching

    check_kind("frame", frame, DepthFrame, FRAME)
    if frame.plane_distance is None:
        raise InvalidInput(
            "a contact needs a frame with plane_distance, the distance from the camera to the flat membrane"
        )
    points, valid = points_of(frame, None, -1.0, frame.plane_distance)
    if not valid.any():
        raise NoContact(
            "no pixel of the frame has depth, so that nothing is seen; look at the camera, and at `plane_distance` and the size of the"
            " membrane in the cell, which leave out other pixels"
        )
    count = count_of(frame)
    even_out(points, count, frame.sequence)
    found = classify(points, valid, rule=rule, stretch=frame.stretch, towards=1)
    check_evened(count, found.noise, found.noise_area)
    labels = found.labels.reshape(-1)
    many = int(np.count_nonzero(labels == CONTACT))
    if not many:
        raise NoContact(
            "no part of the membrane is curved and raised enough to be in contact, beyond the noise of this frame; press deeper, or"
            " average more frames"
        )
    touching, rays = np.empty((2, many, 3), dtype=points.dtype)
    fill_touching(points.reshape(-1, 3), labels, frame.plane_distance, touching, rays)
    return Contact(
        points=touching,
        rays=rays,
        labels=found.labels,
        noise=found.noise,
        hand_height=frame.hand_height,
        stretch=frame.stretch,
        time=frame.time,
        surface=points,
        confidence=found.confidence,
        pose=frame.pose,
        noise_area=found.noise_area,
    )
