"""The base of every node: it reads and writes its ports, ticks, and says why it failed."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Generator
from functools import cache
from threading import get_ident
from typing import TYPE_CHECKING, Any, ClassVar, cast

import py_trees
from py_trees.common import Status

from stretch_bt.errors import BeyondLimits, DeviceFault, NoAnswer, NodeError, StretchError, named, shown, writable
from stretch_bt.forked import here, leave_if_forked
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.declared_ports import declared_ports
from stretch_bt.tree.own_calls import ticks_own
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.slots import Slot, bit, slot

if TYPE_CHECKING:
    from stretch_bt.tree.context import Context

__all__ = ["Behavior"]

#: looked up once, because each `Status.NAME` runs code of Python 3.11's enum
_SUCCESS, _FAILURE, _RUNNING = Status.SUCCESS, Status.FAILURE, Status.RUNNING


class Behavior(py_trees.behaviour.Behaviour):
    """Base of every node that people write.

    Override `update`, and where needed `initialise` (each time the node starts) and `terminate` (once for each start,
    when it ends, breaks or is interrupted). Raise NoAnswer from `update` to fail with its reason. `context` gives the
    time of the tick, the hand and the devices; `reason` explains a FAILURE.
    """

    ports: ClassVar[dict[str, Port]] = {}
    #: bits of the ports that each SUCCESS is asked for: written, else refused or left without a value; bits cost a tick less than a set
    owed: int = 0
    _required: int = 0  # bits of the outputs without which a SUCCESS is refused
    #: outputs whose present value is another quantity than the truth of their port, as a height that is not in the world
    untold: frozenset[str] = frozenset()
    kind: ClassVar[str] = "action"
    #: whether it ends in the tick in which it starts
    instant: ClassVar[bool] = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        own = declared_ports(cls, _taken_names)
        cls.ports = {**cls.ports, **own}
        for name, declared in cls.ports.items():
            if name in own or not isinstance(inspect.getattr_static(cls, name, None), Slot):
                setattr(cls, name, slot(declared, cls.ports))
        cls.owed = sum(bit(p.name, cls.ports) for p in cls.ports.values() if p.written)
        outputs = [p for p in cls.ports.values() if p.role is Role.OUTPUT and not p.check(cls.ports).optional]
        cls._required = sum(bit(p.name, cls.ports) for p in outputs)

    def __init__(self, path: str = "") -> None:
        super().__init__(name=path.rpartition("/")[2] or type(self).__name__)
        self.path = path
        self.runs = 0
        self.active = False
        self.ticking = False
        self.ticked_by = get_ident()  # that ticks it, and alone may write its outputs
        self.owed = self.unwritten = self.owed  # an attribute of the object is read faster than one of its class
        self.context: Context = cast("Context", None)
        self.wiring: dict[str, Callable[[], Any]] = {}
        self.sinks: dict[str, Cell] = {n: Cell(n) for n, p in self.ports.items() if p.written}
        self.device_names: dict[str, str] = {}

    def prepare(self) -> None:
        """Look at what is known before any device is opened; raise InvalidInput for what cannot work. Called once a run."""

    @property
    def reason(self) -> str:
        """Why the node failed, or what it is doing."""
        return str(self.feedback_message)

    @reason.setter
    def reason(self, text: str) -> None:
        if not isinstance(text, str):
            raise NodeError(self.path, f"its reason is {shown(text)}; a reason is one sentence, a str")
        self.feedback_message = writable(text)

    def update(self) -> Status:
        """Do one tick's work and return at once."""
        raise NodeError(self.path, f"{type(self).__name__} does not override update()")

    @ticks_own
    def tick(self) -> Generator[py_trees.behaviour.Behaviour, None, None]:
        """Tick once; a refusal becomes FAILURE with its reason, any other error names the node."""
        self.ticked_by = get_ident()
        self.ticking = True  # stays set when an error leaves the node, so that the runner can name it
        try:
            if self.status is not _RUNNING:
                self.feedback_message = ""
                self.runs += 1
                self.active = True
                self.unwritten = self.owed
                self.initialise()
            status = self.update()
        except NoAnswer as refusal:
            self.feedback_message = self._port_of(refusal) + refusal.reason
            status = _FAILURE
        except StretchError:
            raise
        except Exception as error:
            raise NodeError(self.path, named(error)) from error
        if here.forked:
            leave_if_forked()
        if status is _RUNNING:
            if self.instant:
                raise NodeError(
                    self.path, "returned RUNNING, though it is instant; end in the same tick, or leave out instant"
                )
        else:
            if status is not _SUCCESS and status is not _FAILURE:
                raise NodeError(self.path, f"update() returned {shown(status)}; return SUCCESS, FAILURE or RUNNING")
            if self.unwritten and status is _SUCCESS:
                _check_written(self)
            self.stop(status)
        self.status = status
        self.ticking = False
        yield self

    def _port_of(self, refusal: NoAnswer) -> str:
        """Return which device and port a limit of the cell refused, to begin a reason with."""
        if not isinstance(refusal, BeyondLimits):
            return ""
        ports = [name for name, port in self.ports.items() if port.limit in refusal.concerns]
        if not ports or refusal.reason.startswith(f"{ports[0]} "):  # which names the port itself
            return f"{refusal.device}: "
        return f"{refusal.device}: {ports[0]}: "

    @ticks_own
    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with this status, INVALID when interrupted; `terminate` comes only when there was a start without an end."""
        try:
            if self.active:
                self.active = False
                try:
                    self.terminate(new_status)
                finally:
                    self._release()
        except Exception as error:
            # a fault passes as it is; a plan beyond the limits is a mistake of the node here, where nothing may be asked for
            if isinstance(error, DeviceFault) and not isinstance(error, NoAnswer):
                raise
            raise NodeError(self.path, f"terminate() broke ({named(error)})") from error
        finally:
            if here.forked:
                leave_if_forked()
            self.status = new_status

    def _release(self) -> None:
        """Stop each motion that the node commanded and left under way: nobody would follow it any more."""
        for name in self.device_names.values():
            release = getattr(self.context.devices.get(name), "release", None)
            if release is not None:  # of a device that moves
                release(self.path)


def _check_written(node: Behavior) -> None:
    """Refuse a SUCCESS without an output, or let its key be none where it may be; a port that is read and written keeps its value."""
    lacking = node.unwritten & node._required
    if lacking:
        raise NodeError(node.path, _unwritten([name for at, name in enumerate(node.ports) if lacking >> at & 1]))
    for at, port in enumerate(node.ports.values()):
        if node.unwritten >> at & 1 and (port.role is Role.OUTPUT or node.sinks[port.name].value is MISSING):
            node.sinks[port.name].unset(node.path)


def _unwritten(names: list[str]) -> str:
    """Return what is said of outputs that a SUCCESS lacks."""
    hint = f"write it before, fail, or declare it as {names[0]}: Out[... | None] if it may be absent"
    return f"ended with SUCCESS without writing {', '.join(map(repr, names))}; {hint}"


@cache
def _taken_names() -> frozenset[str]:
    """Return the attributes of every node, which a port of that name would break."""
    return frozenset({*dir(Behavior), *vars(Behavior())})
