"""The node that measures a contact: what it writes, and its refusals."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from stretch_bt.accuracy.perception.noise import WHITE_03, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.perception import find_contact
from stretch_bt.perception.types import Contact
from stretch_bt.runtime.context import RunContext
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.tree.ports import MISSING, Behavior, Role, Status
from stretch_bt.tree.registry import lookup


def measure(contact: Contact, **inputs: Any) -> Behavior:
    info = lookup("measure_contact")
    assert info is not None
    made = info.cls("main/measure_contact")
    made.context = RunContext()
    given = {"contact": contact, **inputs}
    for p in info.of(Role.INPUT):
        made.wiring[p.name] = partial(given.get, p.name, p.default)
    for _ in made.tick():
        pass
    return made


@pytest.fixture(scope="module")
def contact() -> Contact:
    return find_contact(observe(seen(BodyPress(Cylinder(0.02), 0.03, 0.008)), WHITE_03, 2))


def test_it_writes_both_diameters_with_their_errors_and_the_whole_size(contact: Contact) -> None:
    made = measure(contact)
    assert made.status is Status.SUCCESS
    for name in ("diameter_i", "diameter_j"):
        assert abs(made.sinks[name].value - 0.02) < 0.5e-3
        assert 0.05e-3 < made.sinks[name].read_sd() < 1e-3
    assert made.sinks["size"].value.shape == "circle"


def test_the_shape_and_the_fillet_can_be_given(contact: Contact) -> None:
    round_, oval = measure(contact), measure(contact, hypothesis="ellipse", fillet=0.5e-3)
    assert oval.sinks["size"].value.shape == "ellipse"
    assert oval.sinks["diameter_i"].value < round_.sinks["diameter_i"].value - 0.2e-3


def test_it_fails_with_the_reason_where_nothing_touches(contact: Contact) -> None:
    labels = np.where(contact.labels == 2, np.uint8(1), contact.labels)
    none = replace(contact, labels=labels)
    made = measure(none)
    assert made.status is Status.FAILURE
    assert "in contact" in made.reason
    assert made.sinks["diameter_i"].value is MISSING
