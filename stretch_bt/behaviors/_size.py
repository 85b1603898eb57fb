"""Measuring the object in contact by face and skirt, as nodes do."""

from __future__ import annotations

from typing import Literal, TypeAlias

from stretch_bt import perception
from stretch_bt.perception.size.prior import shipped_prior
from stretch_bt.perception.size.result import ContactSize
from stretch_bt.perception.types import Contact

__all__ = ["Skirt", "Wanted", "measured"]

Wanted: TypeAlias = Literal["auto", "circle", "ellipse", "rectangle", "free_form"]
#: skirt of a sheet that does not resist bending, or of one that does
Skirt: TypeAlias = Literal["thin", "thick"]


def measured(
    contact: Contact,
    *,
    hypothesis: Wanted,
    skirt: Skirt,
    mount_prestretch: float,
    **edge: float,
) -> ContactSize:
    """Return the size of the object in contact; the mounts stretch the membrane by `mount_prestretch`, m, at stretch 0; `edge` are the
    `fillet` and `fillet_sd` of `measure_contact`.

    Raises
    ------
    NoAnswer
        The frame does not determine the size.
    """
    return perception.measure_contact(
        contact.surface,
        contact.labels,
        stretch=None if contact.stretch is None else contact.stretch + mount_prestretch,
        hypothesis=hypothesis,
        noise=contact.noise,
        prior=shipped_prior(skirt),
        **edge,
    )
