"""The options of a driver as the model that a cell file is read with, from the frozen dataclass that its author wrote."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from enum import Enum
from pathlib import Path, PurePath
from types import UnionType
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    Protocol,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    runtime_checkable,
)

from pydantic import Field, PrivateAttr, create_model, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.driver import Driver, Mistake, Options
from stretch_bt.source import did_you_mean
from stretch_bt.source.comments import comments_of
from stretch_bt.units import KINDS, Kind
from stretch_bt.within import Within

__all__ = ["options_model"]

#: keys of a device that are not its options
_TAKEN = ("type", "use")


@runtime_checkable
class _TellsMistakes(Protocol):
    """Options that look at the files they name."""

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield (key, mistake, what to write instead)."""


@runtime_checkable
class _TellsOpenings(Protocol):
    """Options of a gripper that know how far it opens."""

    def openings(self) -> tuple[float, float]:
        """Return the least and the greatest opening, m."""


class _Written(Options):
    """Options whose author wrote a dataclass, which is what the driver gets."""

    author: ClassVar[type[Any]]
    _given: Any = PrivateAttr()

    @model_validator(mode="after")
    def _make(self) -> _Written:
        fields = dataclasses.fields(self.author)
        self._given = self.author(**{field.name: getattr(self, field.name) for field in fields if field.init})
        return self

    def given(self) -> Any:
        """Return the dataclass."""
        return self._given

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield what the dataclass finds, if it looks."""
        if isinstance(self._given, _TellsMistakes):
            yield from self._given.mistakes(root)

    def openings(self) -> tuple[float, float] | None:
        """Return what the dataclass says, if it does."""
        return self._given.openings() if isinstance(self._given, _TellsOpenings) else None


def options_model(cls: type[Driver], kind: str, use: str) -> type[Options]:
    """Return the model of a device's entry in a cell file.

    Raises
    ------
    InvalidInput
        The options are neither a frozen dataclass nor a class derived from `Options`, or one has a name or type that cannot be.
    """
    given = cls.Options
    if not isinstance(given, type):
        raise InvalidInput(f"{cls.__name__}.Options is no class; write a frozen dataclass")
    head: dict[str, Any] = {"type": (Literal[kind], ...), "use": (Literal[use], ...)}
    name = f"{cls.__name__}Options"
    if issubclass(given, Options):
        if set(_TAKEN) <= given.model_fields.keys():
            return given
        return create_model(name, __base__=given, __module__=cls.__module__, **head)
    if not dataclasses.is_dataclass(given):
        raise InvalidInput(f"{cls.__name__}.Options is no dataclass; write @dataclass(frozen=True) above it")
    made = create_model(name, __base__=_Written, __module__=cls.__module__, **head, **_fields(cls, given))
    made.author = given
    return made


def _fields(cls: type[Driver], given: type[Any]) -> dict[str, Any]:
    """Return the fields of a dataclass as pydantic takes them; the comment beside one is its description."""
    try:
        hints = get_type_hints(given, include_extras=True)
    except NameError as error:
        raise InvalidInput(
            f"the options of {cls.__name__}: {error}; import what their types need at the top of the module"
        ) from None
    author: Any = given
    docs = comments_of(author)
    found = {}
    for field in dataclasses.fields(given):
        if field.name in _TAKEN or field.name.startswith(("_", "model_")):
            raise InvalidInput(f"an option of {cls.__name__} cannot be called {field.name!r}; choose another name")
        if field.init:
            _check_default(cls, field, hints[field.name])
            found[field.name] = (_annotation(hints[field.name]), _described(field, docs))
    return found


def _check_default(cls: type[Driver], field: dataclasses.Field[Any], hint: Any) -> None:
    """Refuse bounds that nothing fits, and a default outside them: a cell file that leaves the option out is not looked at for it."""
    default, given = field.default, getattr(hint, "__metadata__", ())
    what = f"option {field.name!r} of {cls.__name__}"
    for kind in (item for item in given if isinstance(item, Kind)):
        if isinstance(default, str):
            raise InvalidInput(f"the default of {what} is text; write a number in {kind.si_unit}")
    for within in (item for item in given if isinstance(item, Within)):
        if within.kind is not None and within.kind not in KINDS:
            hint_ = did_you_mean(within.kind, KINDS) or f"write one of {', '.join(KINDS)}"
            raise InvalidInput(f"{what}: no kind of quantity is called {within.kind!r}; {hint_}")
        if not within.min <= within.max:
            raise InvalidInput(
                f"{what}: nothing is within {within.min:g} and {within.max:g}; write the least one first"
            )
        try:
            if isinstance(default, int | float):
                within.check(default)
        except InvalidInput as error:
            raise InvalidInput(f"the default of {what}: {error}") from None


def _described(field: dataclasses.Field[Any], docs: Mapping[str, str]) -> Any:
    doc = docs.get(field.name) or None
    if field.default is not dataclasses.MISSING:
        return Field(default=field.default, description=doc)
    if field.default_factory is not dataclasses.MISSING:
        return Field(default_factory=field.default_factory, description=doc)
    return Field(description=doc)


def _annotation(hint: Any) -> Any:
    """Return a type that takes what YAML has for it: a path is text there, and a tuple a list."""
    origin = get_origin(hint)
    if origin is Annotated:
        bare, *more = get_args(hint)
        return Annotated[(_annotation(bare), *more)]
    if origin in (Union, UnionType):
        return Union[tuple(_annotation(part) for part in get_args(hint))]  # noqa: UP007
    written = origin in (tuple, set, frozenset) or (isinstance(hint, type) and issubclass(hint, PurePath | Enum))
    return Annotated[hint, Field(strict=False)] if written else hint
