"""What a node is: one class with a docstring and typed ports.

A port is an annotation. `In[T]` reads, `Out[T]` writes, `Uses[D]` names a device interface. Building a tree binds each
port to a slot, so that a tick costs one attribute access a port.
"""

from __future__ import annotations

import inspect
import io
import re
import tokenize
import types
import typing
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeVar, cast, overload

import py_trees
from py_trees.common import Status

from stretch_bt.errors import (
    BeyondLimits,
    DeviceFault,
    InvalidInput,
    NoAnswer,
    NodeError,
    StretchError,
    UnsetKey,
    writable,
)
from stretch_bt.tree.port_check import PortCheck
from stretch_bt.units import Estimate

if TYPE_CHECKING:
    from stretch_bt.tree.context import Context

__all__ = [
    "MISSING",
    "Behavior",
    "Cell",
    "In",
    "Out",
    "Port",
    "PortError",
    "RegistryError",
    "Role",
    "Status",
    "Uses",
    "port",
]

T = TypeVar("T")
#: looked up once, because each `Status.NAME` runs code of Python 3.11's enum
_SUCCESS, _FAILURE, _RUNNING = Status.SUCCESS, Status.FAILURE, Status.RUNNING
#: what a port may be called
NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)


class RegistryError(StretchError):
    """A node class cannot be registered; the text says why."""


class PortError(RegistryError, TypeError):
    """A port of a node class is declared wrongly; the text says why."""


class Role(Enum):
    """What a port does."""

    INPUT = "input"
    OUTPUT = "output"
    DEVICE = "device"


In = Annotated[T, Role.INPUT]
Out = Annotated[T, Role.OUTPUT]
Uses = Annotated[T, Role.DEVICE]


class _Missing:
    """The absence of a value, where None is one."""

    def __repr__(self) -> str:
        return "unset"

    def __bool__(self) -> bool:
        return False


MISSING: Any = _Missing()


@dataclass(slots=True)
class _Options:
    default: Any
    min: float | None
    max: float | None
    doc: str
    limit: str | None = None


@overload
def port(
    default: T, *, min: float | None = None, max: float | None = None, doc: str = "", limit: str | None = None
) -> T: ...
@overload
def port(*, min: float | None = None, max: float | None = None, doc: str = "", limit: str | None = None) -> Any: ...
def port(
    default: Any = MISSING,
    *,
    min: float | None = None,  # noqa: A002
    max: float | None = None,  # noqa: A002
    doc: str = "",
    limit: str | None = None,
) -> Any:
    """Give a port a default, bounds (SI, both ends allowed) or a doc; a plain default can also be assigned as it is.

    `limit` names what of a cell's `limits` bounds the port too, such as `depth`: `check` holds trees against it. The speed of a motion
    that is meant to meet something has the limit `contact_speed`, another one `speed`.
    """
    return _Options(default, min, max, doc, limit)


@dataclass(frozen=True, slots=True)
class Port:
    """One port of a node, as its class declares it; `annotation` is the Python type without the role."""

    name: str
    role: Role
    annotation: Any
    default: Any = MISSING
    min: float | None = None
    max: float | None = None
    told: str = ""
    optional: bool = False
    owner: type | None = None
    limit: str | None = None

    @property
    def doc(self) -> str:
        """What it is for: as it was told, or as the comment on the line of its annotation says."""
        return self.told or (_comments(self.owner).get(self.name, "") if self.owner else "")

    @property
    def required(self) -> bool:
        """Whether a tree must give it."""
        return self.role is Role.INPUT and self.default is MISSING

    def check(self, beside: Mapping[str, Port]) -> PortCheck:
        """Return what its values must be; a deviation `x_sd` beside a port `x` is not negative."""
        low = self.min
        if self.name.endswith("_sd") and self.name.removesuffix("_sd") in beside and low is None:
            low = 0.0
        return PortCheck(self.annotation, low, self.max)


class Cell:
    """Where a key's value lives during a run, with its standard deviation."""

    __slots__ = ("blocked", "listener", "name", "sd", "value", "writer")

    def __init__(self, name: str, value: Any = MISSING) -> None:
        self.name = name
        self.value = value
        self.sd: float | None = None
        self.writer = ""
        self.blocked = ""  # why nothing may ever write it
        self.listener: Callable[[Cell], None] | None = None

    def read(self) -> Any:
        """Return the value; raises UnsetKey when nothing wrote it yet."""
        if self.value is MISSING:
            raise UnsetKey(f"${self.name} is read before anything wrote it{self.blocked and '; ' + self.blocked}")
        return self.value

    def read_sd(self) -> float:
        """Return the standard deviation of the value; raises UnsetKey when it has none."""
        if self.value is MISSING or self.sd is None:
            raise UnsetKey(f"${self.name} has no standard deviation")
        return self.sd

    def reset(self, value: Any = MISSING) -> None:
        """Go back to a default, or to unset."""
        self.value = value
        self.sd = None

    def write(self, value: Any, writer: str = "") -> None:
        """Set the value, and its standard deviation when the value is an Estimate; `writer` is the path of a node."""
        if type(value) is Estimate:
            self.sd = value.sd
            value = float(value)
        else:
            self.sd = None
        self.value = value
        self.writer = writer
        if self.listener is not None:
            self.listener(self)

    def unset(self, writer: str = "") -> None:
        """Leave the key without a value, as a node does that writes None to an output that may be absent."""
        self.value, self.sd, self.writer = MISSING, None, writer
        if self.listener is not None:
            self.listener(self)


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
        return node.sinks[self.name].value

    def __set__(self, node: Behavior, value: Any) -> None:
        if type(value) is not self.exact:
            self.judge(node, value)
        else:
            node.unwritten &= self.others
            node.sinks[self.name].write(value, node.path)

    def judge(self, node: Behavior, value: Any) -> None:
        """Write what is not plainly right: as it is to be kept, or raise NodeError; None leaves the key without a value."""
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
        if type(value) is self.exact and self.low <= value <= self.high:  # type: ignore[operator]
            node.unwritten &= self.others
            cell = node.sinks[
                self.name
            ]  # as `Cell.write` does with a plain value; a call would cost more than the check
            cell.value = value
            cell.sd = None
            cell.writer = node.path
            if cell.listener is not None:
                cell.listener(cell)
        else:
            self.judge(node, value)


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


_Slot = _InputSlot | _OutputSlot | _DeviceSlot


def _bit(name: str, ports: Mapping[str, Port]) -> int:
    """Return the bit of an output in `unwritten`; each port has one, in the order of the class."""
    return 1 << list(ports).index(name)


def _slot(declared: Port, ports: Mapping[str, Port]) -> _Slot:
    if declared.role is Role.INPUT:
        return _InputSlot(declared.name)
    if declared.role is Role.DEVICE:
        return _DeviceSlot(declared.name)
    check = declared.check(ports)
    return (_NumberSlot if check.type.is_number else _OutputSlot)(declared.name, check, _bit(declared.name, ports))


class Behavior(py_trees.behaviour.Behaviour):
    """Base of every node that people write.

    Override `update`, and where needed `initialise` (each time the node starts) and `terminate` (once for each start,
    when it ends, breaks or is interrupted). Raise NoAnswer from `update` to fail with its reason. `context` gives the
    time of the tick, the hand and the devices; `reason` explains a FAILURE.
    """

    ports: ClassVar[dict[str, Port]] = {}
    #: bits of the outputs that each SUCCESS must have written; bits cost a tick less than a set
    owed: int = 0
    kind: ClassVar[str] = "action"

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        own = _declared_ports(cls)
        cls.ports = {**cls.ports, **own}
        for name, declared in cls.ports.items():
            if name in own or not isinstance(inspect.getattr_static(cls, name, None), _Slot):
                setattr(cls, name, _slot(declared, cls.ports))
        outputs = [p for p in cls.ports.values() if p.role is Role.OUTPUT]
        cls.owed = sum(_bit(p.name, cls.ports) for p in outputs if not p.check(cls.ports).optional)

    def __init__(self, path: str = "") -> None:
        super().__init__(name=path.rpartition("/")[2] or type(self).__name__)
        self.path = path
        self.runs = 0
        self.active = False
        self.ticking = False
        self.owed = self.unwritten = self.owed  # an attribute of the object is read faster than one of its class
        self.context: Context = cast("Context", None)
        self.wiring: dict[str, Callable[[], Any]] = {}
        self.sinks: dict[str, Cell] = {n: Cell(n) for n, p in self.ports.items() if p.role is Role.OUTPUT}
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
            raise NodeError(self.path, f"its reason is {text!r}; a reason is one sentence, a str")
        self.feedback_message = writable(text)

    def update(self) -> Status:
        """Do one tick's work and return at once."""
        raise NodeError(self.path, f"{type(self).__name__} does not override update()")

    def tick(self) -> Generator[py_trees.behaviour.Behaviour, None, None]:
        """Tick once; a refusal becomes FAILURE with its reason, any other error names the node."""
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
            raise NodeError(self.path, f"{type(error).__name__}: {error}") from error
        if status is not _RUNNING:
            if status is not _SUCCESS and status is not _FAILURE:
                raise NodeError(self.path, f"update() returned {status!r}; return SUCCESS, FAILURE or RUNNING")
            if self.unwritten and status is _SUCCESS:
                raise NodeError(self.path, _unwritten(self))
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

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with this status, INVALID when interrupted; `terminate` comes only when there was a start without an end."""
        try:
            if self.active:
                self.active = False
                self.terminate(new_status)
        except Exception as error:
            # a fault passes as it is; a plan beyond the limits is a mistake of the node here, where nothing may be asked for
            if isinstance(error, DeviceFault) and not isinstance(error, NoAnswer):
                raise
            raise NodeError(self.path, f"terminate() broke ({type(error).__name__}: {error})") from error
        finally:
            self.status = new_status


def _unwritten(node: Behavior) -> str:
    """Return what is said of outputs that a SUCCESS lacks."""
    names = [name for name in node.ports if _bit(name, node.ports) & node.unwritten]
    hint = f"write it before, fail, or declare it as {names[0]}: Out[... | None] if it may be absent"
    return f"ended with SUCCESS without writing {', '.join(map(repr, names))}; {hint}"


@cache
def _taken_names() -> frozenset[str]:
    """Return the attributes of every node, which a port of that name would break."""
    return frozenset({*dir(Behavior), *vars(Behavior()), "instant"})


def _declared_ports(cls: type) -> dict[str, Port]:
    annotations = inspect.get_annotations(cls)
    if not annotations:
        return {}
    hints = typing.get_type_hints(cls, include_extras=True, localns={cls.__name__: cls})
    ports = {}
    for name in annotations:
        role, annotation, optional = _split(hints[name])
        if role is not None:
            _check_name(cls, name)
            ports[name] = _make_port(cls, name, role, annotation, optional)
    return ports


def _check_name(cls: type, name: str) -> None:
    if name in _taken_names():
        raise PortError(
            f"{cls.__name__}: a port cannot be called {name!r}; the word is reserved: every node has it; write {name}_"
        )
    if not NAME.fullmatch(name):
        raise PortError(f"{cls.__name__}: a port cannot be called {name!r}; use letters a to z, digits and _ inside")


def _make_port(cls: type, name: str, role: Role, annotation: Any, optional: bool) -> Port:
    given = cls.__dict__.get(name, MISSING)
    options = given if isinstance(given, _Options) else _Options(given, None, None, "")
    if role is not Role.INPUT and options.default is not MISSING:
        raise PortError(f"{cls.__name__}.{name}: only an input port can have a default")
    return Port(
        name, role, annotation, options.default, options.min, options.max, options.doc, optional, cls, options.limit
    )


def _split(hint: Any) -> tuple[Role | None, Any, bool]:
    """Return the role of an annotation, the annotation without it, and whether None is allowed for a device."""
    if typing.get_origin(hint) is not Annotated:
        return None, hint, False
    base, *metadata = typing.get_args(hint)
    roles = [m for m in metadata if isinstance(m, Role)]
    if not roles:
        return None, hint, False
    rest = tuple(m for m in metadata if not isinstance(m, Role))
    optional = False
    if roles[0] is Role.DEVICE and typing.get_origin(base) in (typing.Union, types.UnionType):
        members = [a for a in typing.get_args(base) if a is not type(None)]
        optional = len(members) < len(typing.get_args(base))
        base = members[0] if len(members) == 1 else base  # the registry refuses the others
    return roles[0], Annotated[(base, *rest)] if rest else base, optional


@cache
def _comments(cls: type) -> dict[str, str]:
    """Return the comment on the line of each annotated attribute, where the source can be read; no run needs to."""
    try:
        source = inspect.getsource(cls)
    except (OSError, TypeError):
        return {}
    found: dict[str, str] = {}
    first_name = ""
    fresh_line = True
    for token in tokenize.generate_tokens(io.StringIO(inspect.cleandoc(source)).readline):
        if token.type in (tokenize.NEWLINE, tokenize.NL, tokenize.INDENT, tokenize.DEDENT):
            fresh_line = True
        elif token.type == tokenize.COMMENT and first_name and not fresh_line:
            found[first_name] = token.string.lstrip("# ").strip()
        elif fresh_line:
            first_name = token.string if token.type == tokenize.NAME else ""
            fresh_line = False
    return found
