"""Reading what a file declares by name: params, keys, inputs and outputs, each with its type, default and bounds."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import cached_property
from typing import Any

from stretch_bt.errors import Diagnostic, InvalidInput
from stretch_bt.source import Map, Scalar, Seq, Value, closest, did_you_mean, is_nothing, told, unknown_key
from stretch_bt.tree.document import Declared
from stretch_bt.tree.types import ANY, UNKNOWN, Family, Type, joined, named
from stretch_bt.tree.values import ValueRefused, check_bounds, is_none, literal, literal_type, refuse
from stretch_bt.units import KINDS, kind_of, misspelt_quantity, parse_quantity, parse_unit

__all__ = ["Declarations", "known_keys", "wrong_unit"]

#: what a scene knows of an object beside the measurements of nodes
OF_SCENE = ("circularity_true", "low_pass_true", "pixel_chain_true", "edge_roughness", "radius_spread", "roundness")
_FRACTION = re.compile(r"\s*([0-9]+)\s*/\s*([1-9][0-9]*)\s*")
_LIST = re.compile(r"\s*\w*\s*[\[(<]\s*(\w+)\s*[\])>]\s*|\s*(\w+)\s*\[\s*\]\s*")
FIELDS = ("type", "default", "min", "max", "unit", "doc")


def known_keys(
    value: Map, known: Iterable[str], what: str, found: list[Diagnostic], hints: Mapping[str, str] | None = None
) -> Map:
    """Note every key that is not known, and return the mapping with those that are only misspelt put right."""
    known = list(known)
    pairs: dict[str, tuple[Scalar, Value]] = {}
    for key, given in value:
        guess = key.text
        if key.text not in known:
            guess = closest(key.text, [name for name in known if name not in value]) or key.text
            hint = (hints or {}).get(key.text) or unknown_key(key, given, known, value)
            found.append(key.mark.error("key-unknown", f"{what} has no {key.text!r}", hint))
        pairs.setdefault(guess, (Scalar(guess, key.quoted, key.mark), given))
    return Map(tuple(pairs.values()), value.mark)


class Declarations:
    """Reads declarations; mistakes are added to `found`.

    `objects` gives the classes that ports carry, by name; few files declare one, and to ask for them imports every node.
    """

    def __init__(self, objects: Callable[[], Mapping[str, type]], found: list[Diagnostic]) -> None:
        self._objects = objects
        self.found = found

    @cached_property
    def objects(self) -> Mapping[str, type]:
        """The classes that ports carry, by name."""
        return self._objects()

    def read(self, key: Scalar, spec: Value, what: str, more: tuple[str, ...] = ()) -> Declared:
        """Read `name: Type` or `name: {type, default, min, max, unit, doc}`, and its further fields; a wrong type is taken for any type."""
        if isinstance(spec, Map):
            spec = known_keys(spec, (*FIELDS, *more), f"a {what}", self.found)
            type_value = spec.get("type")
        else:
            type_value, spec = None if is_nothing(spec) else spec, Map((), spec.mark)
        type_ = self.type(key, type_value, what) if type_value is not None else self.of_values(key, spec, what)
        if type_value is None and self.misspelt(spec.get("default")):
            type_ = ANY
        made = Declared(key.text, type_, key.mark, doc=self.text(spec.get("doc")))
        made.doubtful = type_ is ANY  # which was noted
        made.has_default = "default" in spec
        for read in (self.bounds, self.default, self.unit, self.scene):
            try:
                read(made, spec)
            except ValueRefused as refused:
                self.found.append(refused.diagnostic)
                made.doubtful = True
        return made

    def misspelt(self, value: Value | None) -> bool:
        """Note each quantity with a misspelt unit in a default without a type, which would be a text in silence."""
        items = [value] if isinstance(value, Scalar) else value.items if isinstance(value, Seq) else ()
        before = len(self.found)
        for item in items:
            text = item.text if isinstance(item, Scalar) and not item.quoted else ""
            if (fraction := _FRACTION.fullmatch(text)) is not None:
                message, hint = (
                    f"{text!r} is worked out nowhere",
                    f"write '{float(fraction[1]) / float(fraction[2]):.6g}'",
                )
                self.found.append(item.mark.error("type-mismatch", message, f"{hint}, or put it in quotes for a text"))
            elif (meant := misspelt_quantity(text)) is not None:
                hint = f"{meant}, or put it in quotes for a text"
                self.found.append(item.mark.error("unit-unknown", f"{text!r} reads as a quantity, and is none", hint))
        return len(self.found) > before

    def text(self, value: Value | None) -> str:
        """Read a doc."""
        if value is None:
            return ""
        if not isinstance(value, Scalar):
            self.found.append(value.mark.error("type-mismatch", "doc takes text", "write one sentence, in quotes"))
            return ""
        return " ".join(value.text.split())

    def of_values(self, key: Scalar, spec: Map, what: str) -> Type:
        """Return the type that default and bounds have by themselves; without any, the writers or readers of a key give it one."""
        given = {name: value for name in ("default", "min", "max") if (value := spec.get(name)) is not None}
        types = {name: UNKNOWN if is_none(value) else literal_type(value) for name, value in given.items()}
        found: Type | None = UNKNOWN
        for type_ in types.values():
            found = found and joined(found, type_)
        open_ = what != "param" and all(is_none(value) for value in given.values())
        if found and (found is not UNKNOWN or open_):
            return found
        several = ", ".join(f"{name} is {type_}" for name, type_ in types.items())
        message = f"{what} {key.text!r} has no type" + (f": its {several}" if found is None else "")
        self.found.append(key.mark.error("type-missing", message, "add 'type: Length', or another type"))
        return ANY

    def type(self, key: Scalar, value: Value, what: str) -> Type:
        """Read the name of a type."""
        if isinstance(value, Seq) and len(value.items) == 1 and isinstance(value.items[0], Scalar):  # `[Length]`
            value = Scalar(f"[{value.items[0].text}]", False, value.mark)
        if not isinstance(value, Scalar) or not value.text:
            message, hint = f"{what} {key.text!r} has no type", "add 'type: Length', or another type"
            self.found.append(key.mark.error("type-missing", message, hint))
            return ANY
        type_ = named(value.text, {}) or named(value.text, self.objects)
        if type_ is None:
            known = [*KINDS, "int", "float", "bool", "str", *self.objects]
            listed = (
                "write 'list[Length]', with the type of its entries, and in quotes between braces"
                if value.text in ("list", "List", "array")
                else ""
            )
            hint = (
                listed
                or _meant_as_list(value.text, known)
                or _meant_as_default(value)
                or did_you_mean(value.text, known)
                or f"known here: {', '.join(known)}"
            )
            self.found.append(value.mark.error("type-unknown", f"no type {value.text!r}", hint))
        return type_ or ANY

    def bounds(self, made: Declared, spec: Map) -> None:
        """Read `min` and `max`, for a number or for each item of a list."""
        bounded = made.type.item or made.type
        for name in ("min", "max"):
            value = spec.get(name)
            if value is None or made.type is ANY:
                continue
            if not bounded.is_number:
                hint = f"remove it: only numbers have bounds, and {made.name!r} is {made.type}"
                refuse(spec.key(name).mark, "type-mismatch", f"{name} has no meaning here", hint)
            setattr(made, name, literal(value, bounded, name))
        if made.min is not None and made.max is not None and made.min > made.max:
            made.min = made.max = None
            given = spec.get("min")
            assert given is not None
            refuse(given.mark, "out-of-bounds", f"{made.name}: min is above max", "swap them")
        made.own_bounds = (made.min, made.max)

    def default(self, made: Declared, spec: Map) -> None:
        """Read `default`."""
        value = spec.get("default")
        if value is not None and made.type is not ANY:
            if is_none(value) and made.type.family is not Family.STR:
                return
            default = literal(value, made.type, made.name)
            made.default = default
            check_bounds(default, made.type, made.min, made.max, value.mark, made.name)

    def unit(self, made: Declared, spec: Map) -> None:
        """Read the unit in which an output is shown."""
        value = spec.get("unit")
        if value is None or made.type is ANY:
            return
        made.unit, made.unit_mark = value.text if isinstance(value, Scalar) else told(value), value.mark
        if made.type is not UNKNOWN and (wrong := wrong_unit(made)) is not None:
            raise ValueRefused(wrong)

    def scene(self, made: Declared, spec: Map) -> None:
        """Read whether the scene alone knows an output."""
        value = spec.get("scene")
        if value is None or made.type is ANY:
            return
        if not isinstance(value, Scalar) or not isinstance(value.value, bool):
            refuse(value.mark, "type-mismatch", "scene takes true or false", "write 'scene: true', or leave it out")
        made.scene = value.value
        if made.scene and made.name not in OF_SCENE:
            hint = did_you_mean(made.name, OF_SCENE) or f"known: {', '.join(OF_SCENE)}"
            refuse(made.mark, "name-unknown", f"no scene gives {made.name!r}", hint)
        if made.scene and not made.type.is_number:
            refuse(
                value.mark,
                "type-mismatch",
                f"a scene knows numbers alone, and {made.name!r} is {made.type}",
                "leave it out",
            )
        if made.scene and made.has_default:
            refuse(
                value.mark,
                "type-mismatch",
                f"{made.name!r} has a default, and the scene alone gives it a value",
                "remove one of them",
            )


def wrong_unit(made: Declared) -> Diagnostic | None:
    """Return the mistake in the unit in which a name of known type is to be shown, and forget the unit; None where it fits."""
    if made.unit is None or made.unit_mark is None or made.type in (ANY, UNKNOWN):
        return None
    with suppress(InvalidInput):
        if made.type.kind is not None and parse_unit(made.unit)[1] == made.type.dimension:
            return None
    text, made.unit = made.unit, None
    hint = f"write '{made.type.kind.unit}', or leave it out" if made.type.kind else "leave it out"
    return made.unit_mark.error("unit-mismatch", f"{text!r} is not a unit of {made.type}", hint)


def _meant_as_list(text: str, known: Iterable[str]) -> str:
    """Return a hint for `[Length]`, `List[Length]` or `list[Lenght]`, or nothing."""
    match = _LIST.fullmatch(text)
    guess = match and closest(match[1] or match[2], known)
    return f"write 'list[{guess}]', in quotes between braces" if guess else ""


def _meant_as_default(value: Scalar) -> str:
    """Return a hint for `depth: 10 mm`, which gives a value where a type belongs."""
    given: Any = value.value
    name = {bool: "bool", int: "int", float: "float"}.get(type(given))
    with suppress(InvalidInput):
        kind = kind_of(parse_quantity(value.text)[1])
        name = kind.name if kind else name
    return f"write '{{type: {name}, default: {value.text}}}'" if name else ""
