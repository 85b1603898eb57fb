"""Every shipped node through its life, from the registry: a new node is tested here without a line more."""

from collections.abc import Iterator
from typing import Any

import pytest

import stretch_bt.behaviors
from stretch_bt.errors import NotReady
from stretch_bt.run.context import RunContext
from stretch_bt.tree.ports import Behavior, Role, Status
from stretch_bt.tree.registry import NodeInfo, load_all
from stretch_bt.tree.types import Family

NODES = {
    name: info
    for name, info in load_all().items()
    if info.cls.__module__.startswith(stretch_bt.behaviors.__name__ + ".")
}
WITH_DEVICES = [name for name, info in NODES.items() if any(not p.optional for p in info.of(Role.DEVICE))]
MOVING = [name for name, info in NODES.items() if info.cls.kind == "actuation"]


def placed(info: NodeInfo, devices: dict[str, Any] | None = None, **inputs: Any) -> Behavior:
    """Return a node at its place, with its inputs wired to what is given, to their defaults, or to a plausible number."""
    node = info.cls(f"main/{info.name}")
    node.context = RunContext()
    node.context.devices = devices or {}
    node.context.hand.contact_height = 0.1
    node.device_names = {p.name: p.name for p in info.of(Role.DEVICE) if not p.optional or p.name in (devices or {})}
    for port in info.of(Role.INPUT):
        value = inputs.get(port.name, 0.01 if port.required and info.types[port.name].is_number else port.default)
        node.wiring[port.name] = lambda value=value: value
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
