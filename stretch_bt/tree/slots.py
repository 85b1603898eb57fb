"""How a node reads and writes its ports: one descriptor a port."""

from __future__ import annotations

from collections.abc import Mapping
from threading import get_ident
from typing import TYPE_CHECKING, Any

from stretch_bt.errors import InvalidInput, NodeError
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.port_check import PortCheck

if TYPE_CHECKING:
    from stretch_bt.tree.behavior import Behavior

__all__ = ["Slot", "bit", "slot"]


class _InputSlot:
    """Reads what the tree wired to the port: a constant, a key or an expression."""

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, node: Behavior | None, owner: type) -> Any:
        if node is None:
            return self
        return node.wiring[self.name]()

    def __set__(self, node: Behavior, value: Any) -> None:
        raise NodeError(node.path, f"the input port {self.name!r} cannot be written; write to an output port")


class _OutputSlot:
    """Checks what a node writes, and hands it to the key that the tree wired to the port, if any."""

    __slots__ = ("check", "exact", "name", "others")

    def __init__(self, name: str, check: PortCheck, bit: int) -> None:
        self.name = name
        self.others = ~bit
        self.check = check
        self.exact = check.exact

    def __get__(self, node: Behavior | None, owner: type) -> Any:
        if node is None:
            return self
        cell = node.sinks[self.name]
        if cell.value is MISSING and not cell.writer:
            hint = "keep what it needs in an attribute of the node, or declare the port as InOut[...]"
            raise NodeError(node.path, f"read its output {self.name!r} before it wrote it; {hint}")
        return None if cell.value is MISSING else cell.value

    def __set__(self, node: Behavior, value: Any) -> None:
        if type(value) is not self.exact or get_ident() != node.ticked_by:
            self.judge(node, value)
        else:
            node.unwritten &= self.others
            node.sinks[self.name].write(value, node.path)

    def judge(self, node: Behavior, value: Any) -> None:
        """Write a value that is not plainly right, in the form to be kept, or raise NodeError; None leaves the key without a value."""
        if get_ident() != node.ticked_by:
            hint = "keep what it found in an attribute of the node, and write it in update()"
            raise NodeError(node.path, f"wrote {self.name!r} in another thread than the tree's; {hint}")
        try:
            kept = self.check.judge(value)
        except InvalidInput as error:
            raise NodeError(node.path, f"wrote {self.name!r} wrongly: {error}") from None
        node.unwritten &= self.others
        if kept is None:
            node.sinks[self.name].unset(node.path)
        else:
            node.sinks[self.name].write(kept, node.path)


class _NumberSlot(_OutputSlot):
    """An output of a number: a plain one within its bounds needs no call. NaN and infinity lie in no bounds."""

    __slots__ = ("high", "low")

    def __init__(self, name: str, check: PortCheck, bit: int) -> None:
        super().__init__(name, check, bit)
        self.low, self.high = check.low, check.high

    def __set__(self, node: Behavior, value: Any) -> None:
        if type(value) is self.exact and self.low <= value <= self.high and get_ident() == node.ticked_by:  # type: ignore[operator]
            node.unwritten &= self.others
            cell = node.sinks[
                self.name
            ]  # as `Cell.write` does with a plain value; a call would cost more than the check
            cell.value = value
            cell.sd = None
            cell.writer = node.path
            cell.writes += 1
            if cell.listener is not None:
                cell.listener(cell)
        else:
            self.judge(node, value)


class _InOutSlot(_OutputSlot):
    """Reads the key that the tree wired to the port, None where it may hold nothing, and writes over it."""

    __slots__ = ()

    def __get__(self, node: Behavior | None, owner: type) -> Any:
        if node is None:
            return self
        cell = node.sinks[self.name]
        return None if cell.value is MISSING and self.check.optional else cell.read()


class _DeviceSlot:
    """Hands out the device that the tree declared for the port."""

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, node: Behavior | None, owner: type) -> Any:
        if node is None:
            return self
        device = node.device_names.get(self.name)
        return None if device is None else node.context.device(device)


Slot = _InputSlot | _OutputSlot | _DeviceSlot


def bit(name: str, ports: Mapping[str, Port]) -> int:
    """Return the bit of an output in `unwritten`; each port has one, in the order of the class."""
    return 1 << list(ports).index(name)


def slot(declared: Port, ports: Mapping[str, Port]) -> Slot:
    """Return the descriptor of a port that stands among `ports` in its class."""
    if declared.role is Role.INPUT:
        return _InputSlot(declared.name)
    if declared.role is Role.DEVICE:
        return _DeviceSlot(declared.name)
    check = declared.check(ports)
    if declared.role is Role.INOUT:
        return _InOutSlot(declared.name, check, bit(declared.name, ports))
    return (_NumberSlot if check.type.is_number else _OutputSlot)(declared.name, check, bit(declared.name, ports))
