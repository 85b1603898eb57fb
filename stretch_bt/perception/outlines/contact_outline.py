"""The outline of a contact: the labels' border, moved to where the membrane leaves the body, with the error of its place."""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np

from stretch_bt.arguments import check_kind
from stretch_bt.errors import IllConditioned, NoAnswer
from stretch_bt.perception.leaning import share_beyond
from stretch_bt.perception.outlines.border import border_of, past_labels
from stretch_bt.perception.outlines.outline import Outline, outline_of, placed
from stretch_bt.perception.pitch import pitch_of
from stretch_bt.perception.tension import LEAST_PULL
from stretch_bt.perception.tops import noise_around
from stretch_bt.perception.types import CONTACT, DEFORMED, INVALID, MADE, Contact, MaskArray

__all__ = ["contact_outline"]

LEAST_SOLID = 0.85  # area of a region over its convex hull's
# m, standard deviation of the labels' end from a border that curvature does not show, for a membrane that is pulled and for others, and how much
# it differs along the border, as a part of it (`python benchmarks/outline_errors.py`)
UNSEEN, UNPULLED, UNLIKE = 2.2e-3, 8e-3, 0.4
PART = 1.2  # times the labels that a leaning face holds, from which they are a part of the contact, and their border is none of it
VAGUE = 0.5  # deviation of the border's place over the radius of the disc of the contact's area


def contact_outline(contact: Contact) -> Outline:
    """Return the outline of a contact, in the plane of the flat membrane; the standard deviations include an error of place of all of it.

    The labels reach too far: the border lies inside their region, by the shift that `border_of` returns. Where curvature does not show it,
    as of a membrane that is not pulled, of a contact that is seen in part, or of one that noise or the bending of the sheet hides, the labels
    are taken as they are; the error of place is then `UNSEEN`, or `UNPULLED`, and how far a leaning face reaches past them.

    Raises
    ------
    NoContact, IllConditioned
        As `outline_of`.
    """
    check_kind("contact", contact, Contact, MADE)
    labelled, share = outline_of(contact.labels, contact.surface), _share_beyond(contact)
    if share < PART:
        with suppress(NoAnswer):
            return _moved(contact)
    beyond = (math.sqrt(share) - 1.0) * math.sqrt(labelled.area / math.pi)
    place = math.hypot(UNSEEN if (contact.stretch or 0.0) >= LEAST_PULL else UNPULLED, beyond)
    return placed(labelled, place, 2.0 * math.pi * UNLIKE * place)


def _share_beyond(contact: Contact) -> float:
    """Return how many times the labels the face that leans under them holds, 1 where none is seen."""
    touching, valid = contact.labels == CONTACT, np.asarray(np.isfinite(contact.surface).all(axis=2))
    noise = noise_around(contact.surface, valid, np.flatnonzero(touching))
    return 1.0 if noise is None else share_beyond(contact.surface, valid, touching, noise)


def _moved(contact: Contact) -> Outline:
    """Return the outline moved to the border; raises NoAnswer where curvature does not show that."""
    valid, past = contact.labels != INVALID, past_labels(contact)
    _check_solid(past < 0.0)
    border = border_of(contact)
    shift = border.shift
    inside = past * pitch_of(contact.surface, valid) < -shift.value
    labels = np.where(valid, np.where(inside, CONTACT, DEFORMED), INVALID).astype(np.uint8)
    found = outline_of(labels, contact.surface)
    if shift.sd > VAGUE * math.sqrt(found.area / math.pi):
        raise IllConditioned(
            f"the border of the contact lies {shift.value * 1e3:.1f} +- {shift.sd * 1e3:.1f} mm within the labels, too vague for its size;"
            " average more frames, press deeper, or give a `level`"
        )
    return placed(found, shift.sd, border.uneven)


def _check_solid(region: MaskArray) -> None:
    import cv2

    corners = cv2.convexHull(np.argwhere(region).astype(np.int32))
    solid = np.count_nonzero(region) / max(cv2.contourArea(corners), 1.0)
    if solid < LEAST_SOLID:
        raise IllConditioned(
            f"the pixels labelled as contact fill {solid:.0%} of their convex hull, as a part of a rim does and no contact of a convex body;"
            " press deeper, or give a `level`"
        )
