"""The types of ports, keys and expressions: quantities with a dimension, plain values, lists and objects."""

from __future__ import annotations

import dataclasses
import re
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from typing import Annotated, Any

from stretch_bt.units import DIMENSIONLESS, KINDS, Dimension, Kind, kind_of

__all__ = [
    "ANY",
    "BOOL",
    "FLOAT",
    "INT",
    "NONE",
    "STR",
    "UNKNOWN",
    "Family",
    "Type",
    "annotations_of",
    "attributes",
    "from_annotation",
    "joined",
    "list_of",
    "named",
    "quantity",
    "unaliased",
]


class Family(Enum):
    """The broad families of types."""

    QUANTITY = "quantity"
    FLOAT = "float"
    INT = "int"
    BOOL = "bool"
    STR = "str"
    ENUM = "enum"
    LIST = "list"
    OBJECT = "object"
    NONE = "none"  # of the word for absence
    ANY = "any"  # of a declaration that is wrong, so that its uses are not reported as well


@dataclass(frozen=True, slots=True)
class Type:
    """A type of the tree language; `name` is how files and messages call it."""

    name: str
    family: Family
    dimension: Dimension = DIMENSIONLESS
    options: tuple[str, ...] = ()
    item: Type | None = None
    cls: type | None = None
    #: values of the options, where they are no text, as in `Literal[1, 2]`
    members: tuple[Any, ...] = ()

    def member(self, option: str) -> Any:
        """Return the value of one of the options."""
        return self.members[self.options.index(option)] if self.members else option

    def __str__(self) -> str:
        return self.name

    @property
    def is_record(self) -> bool:
        """Whether a port of this type is wired by its name where a tree leaves it out: an object, or a list of them."""
        return (self.item or self).family is Family.OBJECT

    @property
    def is_number(self) -> bool:
        """Whether arithmetic and bounds make sense."""
        return self.family in (Family.QUANTITY, Family.FLOAT, Family.INT)

    @property
    def kind(self) -> Kind | None:
        """The named kind of quantity, for units."""
        return kind_of(self.dimension) if self.family is Family.QUANTITY else None

    def accepts(self, other: Type) -> bool:
        """Whether a value of the other type can be given where this one is asked for."""
        if Family.ANY in (self.family, other.family):
            return True
        if self.family is Family.QUANTITY or other.family is Family.QUANTITY:
            return self.is_number and other.is_number and self.dimension == other.dimension
        if self.family is Family.FLOAT:
            return other.is_number
        if self.family is Family.ENUM:
            return other.family is Family.ENUM and set(other.options) <= set(self.options)
        if self.family is Family.STR:
            return other.family in (Family.STR, Family.ENUM)
        if self.family is Family.LIST:
            return other.item is not None and self.item is not None and self.item.accepts(other.item)
        if self.family is Family.OBJECT:
            return other.cls is not None and self.cls is not None and issubclass(other.cls, self.cls)
        return self.family is other.family


BOOL = Type("bool", Family.BOOL)
INT = Type("int", Family.INT)
FLOAT = Type("float", Family.FLOAT)
STR = Type("str", Family.STR)
ANY = Type("any", Family.ANY)
#: type of the word for absence, which no type but itself takes
NONE = Type("none", Family.NONE)
#: type of a name whose type follows from its writers or readers
UNKNOWN = Type("unknown", Family.ANY)
_OPTION = re.compile(r"[a-z]\w*")
_PLAIN: dict[Any, Type] = {bool: BOOL, int: INT, float: FLOAT, str: STR}


def quantity(dimension: Dimension) -> Type:
    """Return the type of a number with this dimension."""
    if dimension == DIMENSIONLESS:
        return FLOAT
    return Type(str(dimension), Family.QUANTITY, dimension)


def list_of(item: Type) -> Type:
    """Return the type of a list of such items."""
    return Type(f"list[{item.name}]", Family.LIST, item=item)


def joined(a: Type, b: Type) -> Type | None:
    """Return the type of a key that values of both types are written to, the wider one; None where they do not meet."""
    if a == b or Family.ANY in (a.family, b.family):
        return b if a.family is Family.ANY else a
    if a.item is not None and b.item is not None:
        item = joined(a.item, b.item)
        return None if item is None else list_of(item)
    if {a.family, b.family} <= {Family.STR, Family.ENUM}:
        return STR
    return next((wide for wide, narrow in ((a, b), (b, a)) if wide.accepts(narrow)), None)


def from_annotation(annotation: Any) -> Type:
    """Return the type of a Python annotation such as `Length`, `list[Length]`, `Literal["a", "b"]` or a class.

    Raises
    ------
    TypeError
        The annotation is of no kind that the tree language has.
    """
    annotation = unaliased(annotation)
    origin = typing.get_origin(annotation)
    if origin is Annotated:
        base, *metadata = typing.get_args(annotation)
        kinds = [m for m in metadata if isinstance(m, Kind)]
        return Type(kinds[0].name, Family.QUANTITY, kinds[0].dimension) if kinds else from_annotation(base)
    if origin is typing.Literal:
        members = typing.get_args(annotation)
        options = tuple(str(a) for a in members)
        texts = all(isinstance(a, str) for a in members)
        return Type(" | ".join(options), Family.ENUM, options=options, members=() if texts else members)
    if origin in (list, tuple) or str(origin) == "<class 'collections.abc.Sequence'>":
        return list_of(from_annotation(typing.get_args(annotation)[0]))
    if origin in (typing.Union, types.UnionType):
        options_ = [a for a in typing.get_args(annotation) if a is not type(None)]
        if len(options_) == 1:
            return from_annotation(options_[0])
    if annotation in _PLAIN:
        return _PLAIN[annotation]
    if isinstance(annotation, type) and annotation is not Any:
        return Type(annotation.__name__, Family.OBJECT, cls=annotation)
    raise TypeError(f"{annotation!r} is not a type of the tree language")


def unaliased(annotation: Any) -> Any:
    """Return what an alias stands for: one of a `type` statement (Python 3.12), as `numpy.typing.NDArray` is since numpy 2.5."""
    origin = typing.get_origin(annotation) or annotation
    if not hasattr(origin, "__value__"):
        return annotation
    arguments = typing.get_args(annotation)
    return unaliased(origin.__value__[arguments] if arguments else origin.__value__)


def named(text: str, objects: Mapping[str, type]) -> Type | None:
    """Return the type that a file names, or None; `objects` are the classes that ports carry."""
    text = text.strip()
    if len(text) > 200:  # no name is that long
        return None
    if "|" in text:
        return _options(text)
    if text.startswith("list[") and text.endswith("]"):
        item = named(text[5:-1], objects)
        return None if item is None else list_of(item)
    if text in KINDS:
        return Type(text, Family.QUANTITY, KINDS[text].dimension)
    plain = {t.name: t for t in _PLAIN.values()}
    if text in plain:
        return plain[text]
    cls = objects.get(text)
    return None if cls is None else Type(text, Family.OBJECT, cls=cls)


def _options(text: str) -> Type | None:
    """Return the type of one of several words in lower case, such as `mean | either`."""
    words = tuple(word.strip() for word in text.split("|"))
    right = len(set(words)) == len(words) and all(_OPTION.fullmatch(word) for word in words)
    return Type(" | ".join(words), Family.ENUM, options=words) if right else None


@lru_cache(maxsize=256)
def annotations_of(cls: type) -> Mapping[str, Any]:
    """Return the annotations of the fields and properties of a class."""
    hints: dict[str, Any] = {}
    if dataclasses.is_dataclass(cls):
        hints.update(typing.get_type_hints(cls, include_extras=True))
    for name, member in vars(cls).items():
        if isinstance(member, property) and member.fget is not None:
            hints[name] = typing.get_type_hints(member.fget, include_extras=True).get("return")
    return hints


@lru_cache(maxsize=256)
def attributes(cls: type) -> Mapping[str, Type]:
    """Return the attributes of a class that expressions may read: annotated fields and properties of known types."""
    found: dict[str, Type] = {}
    for name, hint in annotations_of(cls).items():
        if name.startswith("_"):
            continue
        try:
            found[name] = from_annotation(hint)
        except TypeError:  # arrays and the like carry no type of the language
            continue
    return found
