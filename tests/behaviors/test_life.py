"""Every shipped node through its life, from the registry: a new node is tested here without a line more."""

import dataclasses
import inspect
from collections.abc import Iterator
from functools import cache
from typing import Any
from unittest.mock import Mock

import pytest

import stretch_bt.behaviors
from stretch_bt.accuracy.perception.noise import WHITE_03, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.behaviors.protocol_records import Table
from stretch_bt.behaviors.records import FreeMembrane, Touch
from stretch_bt.errors import NotReady
from stretch_bt.runtime.context import RunContext
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.ports import MISSING, Behavior, Port, Role, Status
from stretch_bt.tree.registry import load_all
from stretch_bt.tree.types import Family

NODES = {
    name: info
    for name, info in load_all().items()
    if info.cls.__module__.startswith(stretch_bt.behaviors.__name__ + ".")
}
WITH_DEVICES = [name for name, info in NODES.items() if any(not p.optional for p in info.of(Role.DEVICE))]
MOVING = [name for name, info in NODES.items() if info.cls.kind == "actuation"]


#: of a node, devices and deviations, which stand beside a value, not counted; of its class
MOST_PORTS, MOST_LINES = 10, 80


@cache
def records() -> dict[str, Any]:
    """Return records that nodes read before they use a device; the frame shows a deep contact."""
    return {
        "touch": Touch(0.1, 1e-4),
        "frame": observe(seen(BodyPress(Cylinder(0.02), 0.03, 0.008)), WHITE_03, 2),
        "free_membrane": FreeMembrane(12, "camera", Mock(), Mock()),
        "measured": Table(0, Mock()),
    }


def plausible(info: NodeInfo, port: Port) -> Any:
    """Return a value for a port: its default where it needs none, else a record or a number."""
    if port.required:
        return 0.01 if info.types[port.name].is_number else records().get(port.name, port.default)
    return port.default


def placed(info: NodeInfo, devices: dict[str, Any] | None = None, **inputs: Any) -> Behavior:
    """Return a node at its place, with its ports wired to given values, to their defaults, or to plausible values."""
    node = info.cls(f"main/{info.name}")
    node.context = RunContext()
    node.context.devices = devices or {}
    node.device_names = {p.name: p.name for p in info.of(Role.DEVICE) if not p.optional or p.name in (devices or {})}
    for port in info.of(Role.INPUT):
        value = inputs.get(port.name, plausible(info, port))
        node.wiring[port.name] = lambda value=value: value
    for port in info.of(Role.INOUT):
        value = inputs.get(port.name, plausible(info, port))
        if value is not MISSING:
            node.sinks[port.name].write(value)
    return node


def tick(node: Behavior) -> Status:
    for _ in node.tick():
        pass
    status: Status = node.status
    return status


@pytest.fixture(params=sorted(NODES))
def info(request: pytest.FixtureRequest) -> Iterator[NodeInfo]:
    return NODES[request.param]


def test_there_are_nodes_of_each_kind() -> None:
    assert {info.cls.kind for info in NODES.values()} >= {"actuation", "perception", "model"}
    assert len(NODES) >= 16
    assert len(WITH_DEVICES) >= 6
    assert MOVING
    assert any(info.of(Role.INOUT) for info in NODES.values())


def test_a_node_is_told_to_end_once_for_each_start_and_never_before(
    info: NodeInfo, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[Status] = []
    monkeypatch.setattr(info.cls, "terminate", lambda self, status: told.append(status))
    node = placed(info)
    node.stop(Status.INVALID)
    node.stop(Status.INVALID)
    assert (told, node.status) == ([], Status.INVALID)
    node.active, node.status = True, Status.RUNNING
    node.stop(Status.INVALID)
    node.stop(Status.INVALID)
    assert told == [Status.INVALID]


def test_terminate_itself_does_no_harm_before_a_start_nor_twice(info: NodeInfo) -> None:
    node = placed(info)
    node.terminate(Status.INVALID)
    node.terminate(Status.INVALID)


@pytest.mark.parametrize("name", WITH_DEVICES)
def test_a_missing_device_is_named(name: str) -> None:
    node = placed(NODES[name])
    with pytest.raises(NotReady, match="no such device; name a scene or a cell") as caught:
        tick(node)
    assert caught.value.device in node.device_names.values()
    node.stop(Status.INVALID)


@pytest.mark.parametrize("name", WITH_DEVICES)
def test_constructing_a_node_touches_no_device(name: str) -> None:
    class Untouchable:
        def __getattr__(self, attribute: str) -> Any:
            raise AssertionError(f"{attribute} was used")

    placed(NODES[name], {p.name: Untouchable() for p in NODES[name].of(Role.DEVICE)})


def test_what_a_person_reads_of_a_node_is_there(info: NodeInfo) -> None:
    assert info.doc.endswith(".")
    assert info.cls.update.__doc__
    for port in info.of(Role.INPUT):
        number = info.types[port.name].family in (Family.QUANTITY, Family.INT, Family.FLOAT)
        assert not number or port.min is not None or port.doc or port.required
        if port.default is not None and not port.required and number:
            low, high = port.min, port.max
            assert low is None or low <= port.default
            assert high is None or port.default <= high
    for port in (p for p in info.ports.values() if p.written):
        assert port.doc or port.name.endswith("_sd"), f"say beside {port.name!r} what it holds"


def test_a_node_is_small_enough_to_be_taken_in_at_once(info: NodeInfo) -> None:
    ports = [p.name for p in info.ports.values() if p.role is not Role.DEVICE and not p.name.endswith("_sd")]
    assert len(ports) <= MOST_PORTS, ports
    assert len(inspect.getsource(info.cls).splitlines()) <= MOST_LINES


def test_what_is_written_over_is_a_record_and_no_node_changes_one_in_place(info: NodeInfo) -> None:
    """A reader keeps what it read: whoever has more to say writes another record."""
    assert all(info.types[port.name].is_record for port in info.of(Role.INOUT))
    carried = {(type_.item or type_).cls for type_ in info.types.values()} - {None}
    own = [cls for cls in carried if cls.__module__.startswith(stretch_bt.behaviors.__name__ + ".")]
    for cls in own:
        assert dataclasses.is_dataclass(cls), cls
        assert cls.__dataclass_params__.frozen, cls  # type: ignore[attr-defined]


def test_a_node_that_goes_to_a_depth_needs_the_first_contact_from_which_it_counts(info: NodeInfo) -> None:
    if any(port.limit == "depth" for port in info.ports.values()):
        assert info.ports["touch"].required
