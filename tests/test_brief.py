"""Texts of records with arrays fit a few lines."""

import dataclasses
import typing

import numpy as np
import pytest

from stretch_bt import perception
from stretch_bt.brief import BriefRepr, brief
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import Cloud, Contact
from stretch_bt.tree.registry import object_types
from stretch_bt.tree.types import unaliased

SHOWN = {
    "vector": (np.array([1.0, 2.5]), "[1, 2.5]"),
    "image": (np.array([[0.0, np.nan], [2.0, 1.0]]), "<float64 (2, 2), 0 to 2, 3 of 4 finite>"),
    "counts": (np.full((2, 9), 54321, np.uint16), "<uint16 (2, 9), 54321 to 54321>"),
    "labels": (np.zeros((2, 9), np.uint8), "<uint8 (2, 9), 0 to 0>"),
    "mask": (np.arange(8).reshape(2, 4) > 5, "<bool (2, 4), 2 true>"),
    "nothing": (np.zeros((0, 3)), "<float64 (0, 3)>"),
    "unknown": (np.full((3, 3), np.nan), "<float64 (3, 3), none finite>"),
    "list": ([1.0, 2.0, 3.0, 4.0, 5.0], "[1, 2, 3, 4, ... 5 in all]"),
    "number": (0.1 + 0.2, "0.3"),
}


@pytest.mark.parametrize("what", SHOWN)
def test_values(what):
    value, text = SHOWN[what]
    assert brief(value) == text


def test_records_of_perception_are_short():
    camera = Intrinsics(300.0, 300.0, 79.5, 79.5, 160, 160)
    y, x = np.mgrid[-80:80, -80:80] * 0.5e-3
    contact = Contact.from_heights(np.maximum(8e-3 - (x**2 + y**2) / 40e-3, 0.0), 0.5e-3, noise=1e-4)
    cloud = perception.fuse_contact(contact)
    assert isinstance(cloud, Cloud)
    for record in (contact, cloud, DepthFrame.from_array(np.full((160, 160), 0.1), camera, unit=1e-5)):
        assert len(repr(record)) < 800
        assert "\n" not in repr(record)
    assert f"points=<float64 ({len(cloud)}, 3)" in repr(cloud)


def _is_image(hint: object) -> bool:
    hint = unaliased(hint)
    return typing.get_origin(hint) is np.ndarray or any(_is_image(part) for part in typing.get_args(hint))


def test_every_record_with_an_image_is_short():
    """Small vectors may show their numbers; whatever grows with the image may not."""
    vectors = {"Series", "Dimensions", "Solid", "Sphere", "Plane", "Cylinder", "Cone"}
    records = {cls for cls in object_types().values() if dataclasses.is_dataclass(cls)}
    large = {c for c in records if any(_is_image(hint) for hint in typing.get_type_hints(c).values())}
    assert {c.__name__ for c in large if not issubclass(c, BriefRepr)} <= vectors
    assert {Contact, Cloud, DepthFrame} <= large
