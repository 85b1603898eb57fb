"""What a value of a tree means: a literal, a key, a param or an expression, typed and at its place."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from stretch_bt.errors import Diagnostic, NoAnswer
from stretch_bt.source import TRUTHS, Mark, Scalar, Seq, Value
from stretch_bt.tree.document import Declared, Signature
from stretch_bt.tree.expression import Expression, ExpressionError, bind, names, parse, typecheck
from stretch_bt.tree.expression.parse import Constant, FunctionCall, Name
from stretch_bt.tree.expression.typecheck import Origin, Unresolved
from stretch_bt.tree.flow import Wire
from stretch_bt.tree.scope import TreeScope
from stretch_bt.tree.types import NONE, Family, Type
from stretch_bt.tree.values import (
    NAMED,
    ValueRefused,
    braces,
    check_bounds,
    example,
    is_none,
    literal,
    reads_as_expression,
    written,
)

__all__ = ["ValueWiring"]


class ValueWiring:
    """Reads single values that a tree gives; mistakes are noted and reading goes on."""

    def __init__(self, signature: Signature) -> None:
        self.signature = signature
        self.document = signature.document
        self.scope = TreeScope(signature)
        self.diagnostics: list[Diagnostic] = []

    def error(self, mark: Mark, code: str, message: str, hint: str = "") -> None:
        """Note a mistake."""
        self.diagnostics.append(mark.error(code, message, hint))

    def is_name(self, name: str) -> bool:
        """Whether a name means something in this tree."""
        try:
            self.scope.resolve((name,))
        except Unresolved:
            return self.scope.is_doubtful((name,))
        return True

    @staticmethod
    def of(declared: Declared) -> str:
        """Return the type of a name, with where it comes from."""
        return f"{declared.type} ({'written' if declared.inferred else 'declared'} on line {declared.mark.line})"

    def set_value(self, value: Value, declared: Declared, what: str) -> Wire | None:
        """Return the wire of a `set` to a key: text stands in quotes of its own, because a bare word is a name; `none` leaves it unset."""
        if isinstance(value, Scalar) and declared.type.family in (Family.STR, Family.ENUM) and not is_none(value):
            return self.expression(value, declared.type, what)
        return self.value(value, declared.type, what, declared.min, declared.max, takes_none=True)

    def value(
        self,
        value: Value,
        type_: Type,
        what: str,
        low: float | None = None,
        high: float | None = None,
        *,
        takes_none: bool = False,
    ) -> Wire | None:
        """Return what feeds an input: a literal, or an expression over keys, params and readings."""
        try:
            if takes_none and is_none(value):
                return Wire(value.mark, value=None, text="none")
            if is_none(value) and type_.family is not Family.STR and "none" not in type_.options:
                self.error(value.mark, "value-missing", f"{what} needs a value, and none is given", example(type_))
                return None
            if isinstance(value, Scalar) and self.is_expression(value, type_):
                wire = self.expression(value, type_, what)
            elif isinstance(value, Seq) and type_.family is Family.LIST:
                wire = self.list_value(value, type_, what)
            else:
                wire = Wire(value.mark, value=literal(value, type_, what))
            if wire is not None and wire.is_constant and wire.value is not None:
                check_bounds(wire.value, type_, low, high, value.mark, what)
        except ValueRefused as refused:
            self.diagnostics.append(refused.diagnostic)
            return None
        if wire is not None and wire.is_constant and wire.value is None and not takes_none:
            self.error(
                value.mark,
                "value-missing",
                f"{what} has no value: {wire.text or written(value)} is none",
                example(type_),
            )
            return None
        if wire is not None and not wire.text:
            wire.text = written(value)
        return wire

    def list_value(self, value: Seq, type_: Type, what: str) -> Wire | None:
        """Return a list whose items are literals or params."""
        assert type_.item is not None
        read = [self.value(item, type_.item, what) for item in value.items]
        items = [item for item in read if item is not None]
        if len(items) < len(read):
            return None
        for item in items:
            if not item.is_constant:
                message = f"{what}: an item of a list must be known at load"
                self.error(item.mark, "type-mismatch", message, "use literals or params")
                return None
        return Wire(value.mark, value=[item.value for item in items], items=tuple(item.mark for item in items))

    @staticmethod
    def is_expression(value: Scalar, type_: Type) -> bool:
        """Whether a scalar is to be read as an expression rather than as a literal."""
        if type_.family in (Family.STR, Family.ENUM) and not NAMED.fullmatch(value.text):
            return False
        return reads_as_expression(value)

    def expression(self, value: Value, type_: Type, what: str) -> Wire | None:
        """Read an expression of the wanted type; constants are worked out now."""
        if not isinstance(value, Scalar):
            hint = braces(value) or "write it as text, in quotes"
            self.error(value.mark, "type-mismatch", f"{what} takes an expression", hint)
            return None
        if not value.text:
            hint = "write a condition, as in 'depth > 2 mm'" if type_.family is Family.BOOL else example(type_)
            self.error(value.mark, "value-missing", f"{what} has no value", hint)
            return None
        try:
            found = parse(value.text)
            if any(self.scope.is_doubtful(name.parts) for name in names(found)):
                return None
            given = typecheck(found, self.scope)
        except ExpressionError as error:
            hint = self.literal_meant(value, type_, error)
            self.error(_inside(value, error.offset, error.length), error.code, error.message, hint)
            return None
        never_there = given is NONE and isinstance(found, Name)
        if not (type_.accepts(given) or never_there or _is_option(found, type_)):
            self.mismatch(value, found, given, type_, what)
            return None
        return self.wire(value, found)

    @staticmethod
    def literal_meant(value: Scalar, type_: Type, error: ExpressionError) -> str:
        """Return the hint for a word that may have been meant as a literal and was read as a name."""
        is_open = value.text.count("(") > value.text.count(")")
        if is_open and value.comma and not value.quoted:
            return "put quotes around it: between braces a comma ends the value"
        if is_open and value.text.endswith("("):
            return "write what stands between the brackets, and ')'"
        is_word = error.code == "name-unknown" and value.text.isidentifier()
        if is_word and type_.family in (Family.STR, Family.ENUM, Family.ANY) and error.hint.startswith("known here"):
            return f"text stands in quotes of its own: \"'{value.text}'\"; {error.hint}"
        if is_word and type_.family is Family.BOOL and value.text.lower() in TRUTHS:
            return f"write '{TRUTHS[value.text.lower()]}'"
        if is_word and type_.is_number and error.hint.startswith("known here"):
            return f"{example(type_)}; {error.hint}"
        return error.hint

    def mismatch(self, value: Scalar, expression: Expression, given: Type, wanted: Type, what: str) -> None:
        """Note a value of the wrong type."""
        if wanted.family is Family.QUANTITY and given.is_number and not any(given.dimension):
            message = f"{what} takes {wanted}, but {value.text!r} has no unit"
            self.error(value.mark, "unit-missing", message, "multiply it by a unit")
            return
        hint = f"use a value of type {wanted}"
        if wanted.family is Family.BOOL and given.is_number:
            zero = f"0 {given.kind.unit}" if given.kind else "0"
            hint = f"compare it with something, as in '{value.text} > {zero}'"
        symbol = self.scope.resolve(expression.parts) if isinstance(expression, Name) else None
        declared = self.signature.declared(symbol.name) if symbol is not None and symbol.origin is Origin.KEY else None
        shown = str(given)
        if declared is not None:
            shown += self.of(declared).removeprefix(str(declared.type))
        self.error(value.mark, "type-mismatch", f"{value.text} is {shown} but {what} takes {wanted}", hint)

    def wire(self, value: Scalar, expression: Expression) -> Wire | None:
        """Return the wire of a checked expression, with what it reads."""
        wire = Wire(
            value.mark, expression, text=value.text, source=expression if _passes_error_on(expression) else None
        )
        constant = True
        for name in names(expression):
            symbol = self.scope.resolve(name.parts)
            if symbol.origin in (Origin.KEY, Origin.SD):
                wire.reads += ((symbol.name, _inside(value, name.offset, name.length)),)
                declared = self.signature.ins.get(symbol.name)
                wire.may_be_absent = wire.may_be_absent or (declared is not None and declared.may_be_absent)
            elif symbol.origin is Origin.READING:
                wire.readings += (symbol.name,)
            elif symbol.origin is Origin.PARAM and (error := self.document.params.get(f"{symbol.name}_sd")) is not None:
                error.used = True  # it goes with the value
            constant = constant and symbol.origin is Origin.PARAM
        if not constant:
            return wire
        if isinstance(expression, Name) and self.scope.resolve(expression.parts).value is None:  # a param that is none
            wire.value = None
            return wire
        try:
            wire.value = bind(expression, _Params(self.scope))()
        except (ArithmeticError, IndexError, ValueError, NoAnswer) as error:
            why = str(error).replace(" has no value: ", ": ").removeprefix(f"{value.text}: ")
            message = f"{value.text!r} has no value: {why}"
            self.error(value.mark, "expression", message, "change the params, or the expression")
            return None
        if isinstance(wire.value, float) and not math.isfinite(wire.value):
            message = f"{value.text!r} is not a finite number"
            self.error(value.mark, "expression", message, "change the params, or the expression")
            return None
        return wire


def _is_option(expression: Expression, type_: Type) -> bool:
    """Whether an expression is one of the words that a type lists, in quotes of its own."""
    return isinstance(expression, Constant) and type_.family is Family.ENUM and expression.value in type_.options


def _passes_error_on(expression: Expression) -> bool:
    """Whether the value of an expression carries the error of its parts."""
    carries = ("mean", "median", "min", "max", "at")
    if not isinstance(expression, FunctionCall):
        return isinstance(expression, Name)
    return expression.function in carries and len(expression.arguments) <= 1 + (expression.function == "at")


class _Params:
    """Values of params, for expressions that need nothing else."""

    def __init__(self, scope: TreeScope) -> None:
        self.scope = scope

    def source(self, parts: tuple[str, ...]) -> tuple[Callable[[], Any], tuple[str, ...]]:
        """Return the value of a param."""
        symbol = self.scope.resolve(parts)
        return symbol.read, parts[symbol.used :]


def _inside(value: Scalar, offset: int, length: int) -> Mark:
    """Return the place of a part of a scalar; a quote shifts it by one, a folded text keeps its start."""
    if value.mark.length < len(value.text):
        return value.mark
    return value.mark.shifted(offset + (1 if value.quoted else 0), max(length, 1))
