"""What behaviours of other packages did in a record: a replay takes it from there, because they may go by the machine's clock."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any, cast

from py_trees.common import Status

from stretch_bt.errors import NodeError
from stretch_bt.runtime.cut_off import CutOff
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.replay.log import Diverged
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.foreign.node import ForeignNode
from stretch_bt.tree.types import Family, Type, from_annotation
from stretch_bt.units import Estimate

__all__ = ["repeat_behaviours"]

#: events that say how the code of a node broke
_BROKEN = ("error", "finally", "stop_error")
#: the status of a node that was interrupted from above
_INTERRUPTED = Status.INVALID.name


def repeat_behaviours(tree: BuiltTree, reader: RecordReader) -> None:
    """Let the behaviours of other packages in a tree do what they did in a record, instead of ticking them."""
    for node in tree.foreign:
        node.recorded = _Again(node, reader)


class _Again:
    """The writes and statuses of one node, tick by tick."""

    def __init__(self, node: ForeignNode, reader: RecordReader) -> None:
        self._node = node
        self._ports = {node.sinks[name].name: name for name in node.slots}
        self._done = deque(event for event in reader.events if _is_of(event, node.path))
        broken = [event for event in reader.events if event["type"] in _BROKEN]
        self._broken = [event for event in broken if str(event["reason"]).startswith(f"{node.path}: ")]
        self._cut = {event["tick"] for event in reader.events if event.get("cut_off") == node.path}

    def set_up(self) -> None:
        """Break as it broke."""
        self._break("setup() broke")

    def shut_down(self) -> None:
        """Break as it broke."""
        self._break("shutdown() broke")

    def tick(self) -> Status:
        """Write what it wrote in this tick, and return its status."""
        tick = self._node.context.ticks
        while self._done and self._done[0]["tick"] < tick:
            self._done.popleft()
        while self._done and self._done[0]["tick"] == tick and self._done[0].get("status") != _INTERRUPTED:
            event = self._done.popleft()
            if event["type"] == "status":
                self._node.unwritten = 0  # a value that goes to no key is in no record
                self._node.reason = event.get("reason", "")
                return Status[event["status"]]
            self._write(event)
        if tick in self._cut:
            raise CutOff(self._node.path)
        self._break("", tick)
        return self._goes_on()

    def _goes_on(self) -> Status:
        """Run on; its last reason is in the record where it was interrupted."""
        following = next((event for event in self._done if event["type"] == "status"), None)
        if following is not None and following["status"] == _INTERRUPTED:
            self._node.reason = following.get("reason", "")
        return Status.RUNNING

    def _break(self, how: str, tick: int | None = None) -> None:
        for event in self._broken:
            reason = str(event["reason"]).removeprefix(f"{self._node.path}: ")
            # an error before the first tick or after the last is distinguished from an error in a tick
            outside = tick is not None and reason.startswith(("setup() broke", "shutdown() broke"))
            if reason.startswith(how) and tick in (None, event["tick"]) and not outside:
                raise NodeError(self._node.path, reason)

    def _write(self, event: Mapping[str, Any]) -> None:
        name = self._ports.get(event["key"])
        if name is not None:
            type_ = from_annotation(self._node.ports[name].annotation)
            value: Any = None if event["value"] is None else self._value(event["value"], type_)
            self._node.put(name, Estimate(value, event["sd"]) if "sd" in event else value)

    def _value(self, value: Any, type_: Type) -> Any:
        """Return what was written; of an object a record holds the fields alone."""
        if type_.item is not None:
            return [self._value(item, type_.item) for item in value]
        if type_.family is not Family.OBJECT:
            return value
        plain = isinstance(value, dict) and not any(isinstance(field, dict | list) for field in value.values())
        if plain and is_dataclass(type_.cls):
            return cast("Any", type_.cls)(**value)
        raise Diverged(f"{self._node.path}: it wrote a {type_}, of which a record holds too little to write it again")


def _is_of(event: Mapping[str, Any], path: str) -> bool:
    """Whether an event is a write or a status of this node."""
    return event.get("path") == path and event["type"] in ("write", "status")
