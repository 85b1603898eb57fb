"""What a port is: its role, type, default, bounds and doc."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Any, TypeVar, overload

from stretch_bt.source.comments import comments_of
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.port_check import PortCheck

__all__ = ["In", "InOut", "Options", "Out", "Port", "Role", "Uses", "port"]

T = TypeVar("T")


class Role(Enum):
    """What a port does."""

    INPUT = "input"
    OUTPUT = "output"
    INOUT = "inout"  # read, and written over
    DEVICE = "device"


In = Annotated[T, Role.INPUT]
Out = Annotated[T, Role.OUTPUT]
InOut = Annotated[T, Role.INOUT]
Uses = Annotated[T, Role.DEVICE]


@dataclass(slots=True)
class Options:
    """What `port` was given."""

    default: Any
    min: float | None
    max: float | None
    doc: str
    limit: str | None = None
    truth: str | Mapping[str, str] | None = None


@overload
def port(
    default: T, *, min: float | None = None, max: float | None = None, doc: str = "", limit: str | None = None
) -> T: ...
@overload
def port(
    *,
    min: float | None = None,
    max: float | None = None,
    doc: str = "",
    limit: str | None = None,
    truth: str | Mapping[str, str] | None = None,
) -> Any: ...
def port(
    default: Any = MISSING,
    *,
    min: float | None = None,  # noqa: A002
    max: float | None = None,  # noqa: A002
    doc: str = "",
    limit: str | None = None,
    truth: str | Mapping[str, str] | None = None,
) -> Any:
    """Give a port a default, bounds (SI, both ends allowed) or a doc; a plain default can also be assigned as it is.

    `limit` names what of a cell's `limits` bounds the port too, such as `depth`: `check` holds trees against it. The speed of a motion
    that is meant to meet something has the limit `contact_speed`, another one `speed`.

    `truth` names the quantity of the scene that an output is compared with, at the moment the node writes it, such as `deflection`; for
    an output with attributes it is a mapping from them, such as `{"radius": "radius"}`.
    """
    return Options(default, min, max, doc, limit, truth)


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
    truth: Mapping[str, str] = field(default_factory=dict, hash=False)  # by attribute, "" for the value itself
    #: whether it is a constructor argument of a behaviour, which is made once
    fixed: bool = False

    @property
    def doc(self) -> str:
        """Its purpose: the text that it was given, or the comment on the line of its annotation."""
        return self.told or (comments_of(self.owner).get(self.name, "") if self.owner else "")

    @property
    def required(self) -> bool:
        """Whether a tree must give it; a record that is read and written over need not be there before where it may be None."""
        if self.role is Role.INOUT:
            check = self.check({})
            return not (check.optional and check.type.is_record)
        return self.role is Role.INPUT and self.default is MISSING

    @property
    def written(self) -> bool:
        """Whether the node writes it."""
        return self.role in (Role.OUTPUT, Role.INOUT)

    def check(self, beside: Mapping[str, Port]) -> PortCheck:
        """Return the check of its values; a deviation `x_sd` beside a port `x` is not negative."""
        low = self.min
        if self.name.endswith("_sd") and self.name.removesuffix("_sd") in beside and low is None:
            low = 0.0
        return PortCheck(self.annotation, low, self.max)
