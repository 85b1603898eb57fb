"""The grammar of expressions: comparisons, and/or/not, + - * /, a few functions, numbers with units, names.

A Pratt parser over a flat list of tokens; every node knows its offset in the text, for messages.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple

from stretch_bt.errors import InvalidInput, StretchError
from stretch_bt.tree.types import BOOL, FLOAT, INT, NONE, STR, Type, quantity
from stretch_bt.units import NUMBER, parse_quantity

__all__ = [
    "EQUALITIES",
    "Binary",
    "Constant",
    "Expression",
    "ExpressionError",
    "FunctionCall",
    "Name",
    "Unary",
    "parse",
]

MAX_LENGTH = 1000
MAX_TOKENS = 200
MAX_DEPTH = 50


class ExpressionError(StretchError):
    """An expression is wrong at `offset` characters into its text."""

    def __init__(self, offset: int, length: int, code: str, message: str, hint: str = "") -> None:
        self.offset, self.length, self.code, self.message, self.hint = offset, length, code, message, hint
        super().__init__(message)


@dataclass(slots=True)
class Expression:
    """Base of the nodes; `type` is filled in by the type check."""

    offset: int
    length: int
    type: Type = field(default=FLOAT, init=False)


@dataclass(slots=True)
class Constant(Expression):
    """A number with or without a unit (SI), a boolean or text."""

    value: object


@dataclass(slots=True)
class Name(Expression):
    """A dotted name: a key, a param, a device's reading, or an attribute of one of them."""

    parts: tuple[str, ...]


@dataclass(slots=True)
class Unary(Expression):
    """`-x` or `not x`."""

    operator: str
    operand: Expression


@dataclass(slots=True)
class Binary(Expression):
    """Two operands and what stands between them."""

    operator: str
    left: Expression
    right: Expression


@dataclass(slots=True)
class FunctionCall(Expression):
    """A function of the short list."""

    function: str
    arguments: tuple[Expression, ...]


class _Token(NamedTuple):
    kind: str
    text: str
    offset: int


_UNIT = r"(?:[a-zA-Zµ%]+(?:\^-?[0-9]+)?(?:[*/][a-zA-Zµ]+(?:\^-?[0-9]+)?)*|1/[a-zA-Zµ]+(?:\^[0-9]+)?)"
_WORD_AFTER_NUMBER = r"(?!(?:and|or|not|in)\b)"
_TOKEN = re.compile(
    rf"(?P<space>\s+)"
    rf"|(?P<number>{NUMBER.removeprefix('[-+]?')}(?:[ ]?{_WORD_AFTER_NUMBER}{_UNIT}(?![\w.$(]))?)"
    r"|(?P<text>'[^']*'|\"[^\"]*\")"
    r"|(?P<name>\$?[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z0-9_]+)*)"
    r"|(?P<operator><=|>=|==|!=|[-+*/<>(),])"
)
_BINDING = {
    "or": 10,
    "and": 20,
    "<": 40,
    "<=": 40,
    ">": 40,
    ">=": 40,
    "==": 40,
    "!=": 40,
    "+": 50,
    "-": 50,
    "*": 60,
    "/": 60,
}
EQUALITIES = ("==", "!=")
_COMPARISONS = ("<", "<=", ">", ">=", *EQUALITIES)
FUNCTIONS = {
    "abs": (1, 1),
    "min": (1, 8),
    "max": (1, 8),
    "sqrt": (1, 1),
    "mean": (1, 1),
    "median": (1, 1),
    "sum": (1, 1),
    "len": (1, 1),
    "sort": (1, 1),
    "argmin": (1, 1),
    "at": (2, 2),
}


def parse(text: str) -> Expression:
    """Return the tree of an expression; raises ExpressionError at the offset of the mistake."""
    if len(text) > MAX_LENGTH:
        raise ExpressionError(0, 1, "expression", f"an expression over {MAX_LENGTH} characters", "use a node instead")
    return _Parser(text).whole()


class _Parser:
    def __init__(self, text: str) -> None:
        self.tokens = list(self.scan(text))
        if len(self.tokens) > MAX_TOKENS:
            message = f"an expression of more than {MAX_TOKENS} words and signs"
            raise ExpressionError(0, 1, "expression", message, "split it with 'set'")
        self.position = 0
        self.depth = 0

    @staticmethod
    def scan(text: str) -> list[_Token]:
        tokens, position = [], 0
        while position < len(text):
            match = _TOKEN.match(text, position)
            if match is None:
                raise _unexpected(text, position)
            if match.lastgroup != "space":
                kind = "operator" if match[0] in ("and", "or", "not") else str(match.lastgroup)
                tokens.append(_Token(kind, match[0], position))
            position = match.end()
        tokens.append(_Token("end", "", len(text.rstrip())))
        return tokens

    def whole(self) -> Expression:
        found = self.expression(0)
        token = self.tokens[self.position]
        if token.kind != "end":
            raise ExpressionError(
                token.offset,
                len(token.text),
                "expression",
                f"{token.text!r} is not expected here",
                "write '==' or '!='" if token.text in ("is", "isnt", "equals") else "put an operator before it",
            )
        return found

    def next(self) -> _Token:
        token = self.tokens[self.position]
        self.position += 1
        return token

    def expression(self, strength: int) -> Expression:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise ExpressionError(0, 1, "expression", f"nested deeper than {MAX_DEPTH}", "split it with 'set'")
        left = self.prefix()
        while (binding := _BINDING.get(self.tokens[self.position].text, 0)) > strength:
            operator = self.next()
            chained = operator.text in _COMPARISONS and isinstance(left, Binary) and left.operator in _COMPARISONS
            if chained and self.tokens[self.position - 2].text != ")":
                hint = "write 'a < b and b < c'"
                raise ExpressionError(operator.offset, len(operator.text), "expression", "chained comparison", hint)
            right = self.expression(binding)
            end = right.offset + right.length
            left = Binary(left.offset, end - left.offset, operator.text, left, right)
        self.depth -= 1
        return left

    def prefix(self) -> Expression:
        token = self.next()
        if token.kind == "number":
            return _number(token)
        if token.kind == "text":
            return _constant(token, token.text[1:-1], STR)
        if token.kind == "name":
            return self.name(token)
        if token.text == "(":
            inner = self.expression(0)
            self.expect(")")
            return inner
        if token.text in ("-", "not"):
            operand = self.expression(70 if token.text == "-" else 30)
            return Unary(token.offset, operand.offset + operand.length - token.offset, token.text, operand)
        what = "the expression ends too early" if token.kind == "end" else f"{token.text!r} is not expected here"
        raise ExpressionError(token.offset, max(len(token.text), 1), "expression", what, "a value is missing here")

    def name(self, token: _Token) -> Expression:
        if token.text in ("true", "false"):
            return _constant(token, token.text == "true", BOOL)
        if token.text == "none":
            return _constant(token, None, NONE)
        if self.tokens[self.position].text == "(":
            return self.call(token)
        return Name(token.offset, len(token.text), tuple(token.text.removeprefix("$").split(".")))

    def call(self, token: _Token) -> Expression:
        if token.text not in FUNCTIONS:
            hint = f"functions are {', '.join(FUNCTIONS)}"
            raise ExpressionError(
                token.offset, len(token.text), "function-unknown", f"no function {token.text!r}", hint
            )
        self.next()
        arguments = [self.expression(0)]
        while self.tokens[self.position].text == ",":
            self.next()
            arguments.append(self.expression(0))
        end = self.expect(")")
        low, high = FUNCTIONS[token.text]
        if not low <= len(arguments) <= high:
            message = f"{token.text}() takes {low if low == high else f'{low} to {high}'} values, got {len(arguments)}"
            raise ExpressionError(token.offset, len(token.text), "expression", message, "change the number of values")
        return FunctionCall(token.offset, end.offset + 1 - token.offset, token.text, tuple(arguments))

    def expect(self, text: str) -> _Token:
        token = self.next()
        if token.text != text:
            raise ExpressionError(
                token.offset, max(len(token.text), 1), "expression", f"{text!r} is missing", f"add {text!r}"
            )
        return token


def _unexpected(text: str, position: int) -> ExpressionError:
    hints = {
        "=": "write '==' to compare",
        "&&": "write 'and'",
        "&": "write 'and'",
        "||": "write 'or'",
        "|": "write 'or'",
        "!": "write 'not '",
        "[": "write '.0' in place of '[0]' to take an item",
        "{": "write '$key' without braces",
        "**": "write 'x * x'",
        "^": "write 'x * x'",
    }
    sign = next((s for s in hints if text.startswith(s, position)), text[position])
    if not sign.isascii() and sign.isalnum():
        hints[sign] = "names have letters a to z, digits and _, numbers the digits 0 to 9"
    hint = hints.get(sign, "expressions know names, numbers with units, + - * /, comparisons, and, or, not")
    return ExpressionError(position, len(sign), "expression", f"{sign!r} has no meaning in an expression", hint)


def _number(token: _Token) -> Constant:
    try:
        value, dimension = parse_quantity(token.text)
    except InvalidInput as error:
        hint = "units are written as in '10 mm' or '1.5 N/mm'"
        raise ExpressionError(token.offset, len(token.text), "unit-unknown", str(error), hint) from None
    whole = token.text.isdigit()
    return _constant(token, int(token.text) if whole else value, INT if whole else quantity(dimension))


def _constant(token: _Token, value: object, type_: Type) -> Constant:
    constant = Constant(token.offset, len(token.text), value)
    constant.type = type_
    return constant
