"""The whole membrane as one contact saw it, in the world."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.perception.deprojection import to_world
from stretch_bt.perception.types import CONTACT, INVALID, Contact

__all__ = ["SolidView", "view_of", "views_of"]

Array = npt.NDArray[np.float64]

BELOW = 3e-3  # m, largest sag of a membrane below its own plane; deeper points are seen past its sides
FEWEST = 200  # points


@dataclass(frozen=True, slots=True)
class SolidView:
    """Points (n, 3), m, of the membrane in the world, where it touches, and where the hand stood (3,), m.

    `noise`, m, is the standard deviation of one point's height, `shared`, m, the standard deviation of an error that all share.
    """

    points: Array
    touching: npt.NDArray[np.bool_]
    hand: Array
    noise: float
    shared: float

    @property
    def top(self) -> float:
        """World height that one touching point in fifty exceeds, m."""
        return float(np.quantile(self.points[self.touching, 2], 0.98))


def view_of(contact: Contact) -> SolidView:
    """Return the surface of a contact in the world.

    Raises
    ------
    InvalidInput
        The contact does not know the pose of the hand.
    NoContact
        It has no point, or too few.
    """
    if contact.pose is None:
        raise InvalidInput("a shape in the world takes contacts that know the pose of the hand; this one does not")
    points = np.asarray(contact.surface, np.float64).reshape(-1, 3)
    labels = np.asarray(contact.labels).reshape(-1)
    kept = np.isfinite(points).all(axis=1) & (labels != INVALID) & (points[:, 2] > -BELOW)
    if np.count_nonzero(kept) < FEWEST or not (labels[kept] == CONTACT).any():
        raise NoContact(
            f"the surface of a contact has {np.count_nonzero(kept)} points; a shape takes {FEWEST}; press deeper"
        )
    world = to_world(points[kept], contact.pose)
    area = max(contact.noise_area, 1.0)
    shared = contact.noise * float(np.sqrt(min(area / max(len(contact.points), 1), 1.0)))
    return SolidView(world, labels[kept] == CONTACT, np.array(contact.pose.position), max(contact.noise, 1e-6), shared)


def views_of(contacts: Iterable[Contact]) -> list[SolidView]:
    """Return the surfaces of contacts in the world.

    Raises
    ------
    NoContact, InvalidInput
        As `view_of`, or there is no contact.
    """
    views = [view_of(contact) for contact in contacts]
    if not views:
        raise NoContact("there is no contact to fit a shape to; press the object first")
    return views
