"""The node that ticks a behaviour of py_trees or of another package."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from stretch_bt.blame import own_code
from stretch_bt.errors import NodeError, shown
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.foreign.board import PortBoard
from stretch_bt.tree.foreign.written import Written
from stretch_bt.tree.own_calls import calls_own, ticks_own
from stretch_bt.tree.port import Role
from stretch_bt.tree.slots import Slot

__all__ = ["ForeignNode", "Made", "Recorded"]


#: timeout for a `setup` that takes one, as it did before py_trees 2, s; nothing enforces it
SETUP_TIME = 15.0


@dataclass(frozen=True, slots=True)
class Made:
    """How a behaviour is made: its class, whether that takes a name, and how the values of a file become its own."""

    cls: type[Behaviour]
    takes_name: bool
    arguments: Mapping[str, Written]
    ports: Mapping[str, Written]

    def instance(self, name: str, given: Mapping[str, Any]) -> Any:
        """Return a behaviour with these arguments."""
        named = {"name": name} if self.takes_name else {}
        return self.cls(**named, **{key: self.arguments[key].made(value) for key, value in given.items()})


class Recorded(Protocol):
    """What a behaviour did in a record."""

    def set_up(self) -> None:
        """Break as it broke."""
        ...

    def tick(self) -> Status:
        """Write what it wrote in this tick, and return its status."""
        ...

    def shut_down(self) -> None:
        """Break as it broke."""
        ...


class ForeignNode(Behavior):
    """Ticks a behaviour that knows neither ports of ours nor the clock of the run; it is made once for each place."""

    kind: ClassVar[str] = "behaviour"
    made: ClassVar[Made]
    slots: ClassVar[dict[str, Slot]] = {}

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        #: the constructor arguments that the place gives; the class has its own defaults for the others
        self.given: dict[str, Any] = {}
        self.inner: Behaviour | None = None
        self.is_set_up = False
        self._board: PortBoard | None = None
        #: stands in for the behaviour in a replay
        self.recorded: Recorded | None = None

    def prepare(self) -> None:
        """Make the behaviour, so that a refusal of its constructor is reported before any device is opened."""
        if self.recorded is None:
            self._behaviour()

    def _behaviour(self) -> Behaviour:
        if self.inner is None:
            with own_code(self.path, f"{self.made.cls.__name__}()"):
                inner = self.made.instance(self.name, self.given)
                if not isinstance(inner, Behaviour) or not hasattr(inner, "blackbox_level"):
                    hint = "begin its __init__ with super().__init__(name)"
                    raise NodeError(self.path, f"{self.made.cls.__name__}() gave {shown(inner)}, no behaviour; {hint}")
                self._board = PortBoard(inner, self._names(Role.INPUT), self._names(Role.OUTPUT))
            self.inner = inner
        return self.inner

    def _names(self, role: Role) -> list[str]:
        return [port.name for port in self.ports.values() if port.role is role and not port.fixed]

    @ticks_own
    def setup(self, **kwargs: Any) -> None:
        """Call `setup` of the behaviour and of those inside it, children first, as py_trees does; an old one asks for a timeout."""
        if self.recorded is not None:
            self.recorded.set_up()
            return
        inner = self._behaviour()
        self.is_set_up = True
        with own_code(self.path, "setup()"):
            for node in inner.iterate():
                asked = inspect.signature(node.setup).parameters
                node.setup(**({"timeout": SETUP_TIME} if "timeout" in asked else {}), **kwargs)

    @ticks_own
    def shutdown(self) -> None:
        """Call `shutdown` of the behaviour and of those inside it, where `setup` was begun; one that breaks keeps none from it."""
        if self.recorded is not None:
            self.recorded.shut_down()
            return
        if not self.is_set_up or self.inner is None:
            return
        self.is_set_up = False
        first: BaseException | None = None
        for node in self.inner.iterate():
            try:
                with own_code(self.path, "shutdown()"):
                    node.shutdown()
            except BaseException as error:
                first = first or error
        if first is not None:
            raise first

    @calls_own
    def initialise(self) -> None:
        """Begin anew; the behaviour's own `initialise` comes with its tick."""
        if self.recorded is None:
            self._behaviour()
            assert self._board is not None
            self._board.begin()

    @calls_own
    def update(self) -> Status:
        """Tick the behaviour once."""
        if self.recorded is not None:
            return self.recorded.tick()
        inner, board = self._behaviour(), self._board
        assert board is not None
        for name in board.inputs:
            value = self.wiring[name]()
            board.give(name, None if value is None else self.made.ports[name].made(value))
        inner.tick_once()
        for name, value in board.take().items():
            self.put(name, self.made.ports[name].back(value))
        if inner.status is Status.SUCCESS:
            self._leave_out(board.unwritten())
        self.reason = str(inner.feedback_message)
        return inner.status

    def _leave_out(self, unwritten: list[str]) -> None:
        """Let the keys of outputs that were not written be none, where they may be."""
        for name in unwritten:
            if self.ports[name].check({}).optional:
                self.put(name, None)

    def put(self, name: str, value: Any) -> None:
        """Write an output."""
        self.slots[name].__set__(self, value)  # type: ignore[union-attr]

    @calls_own
    def terminate(self, new_status: Status) -> None:
        """Interrupt the behaviour; one that ended by itself was terminated within its tick."""
        if new_status is Status.INVALID and self.inner is not None:
            self.inner.stop(Status.INVALID)
