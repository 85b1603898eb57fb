"""The expression language: values, units, precedence, and errors at their offset."""

import math
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import Absent, InvalidInput
from stretch_bt.frames import Intrinsics
from stretch_bt.source import Mark, Scalar
from stretch_bt.tree.expression import ExpressionError, bind, names, parse, typecheck
from stretch_bt.tree.expression.typecheck import Origin, Symbol, Unresolved
from stretch_bt.tree.types import BOOL, FLOAT, INT, STR, Family, Type, quantity
from stretch_bt.tree.values import reads_as_expression
from stretch_bt.units import KINDS, Dimension, Kind

LENGTH, FORCE, TIME = (quantity(KINDS[name].dimension) for name in ("Length", "Force", "Time"))
LISTED = Type("list[Length]", Family.LIST, item=LENGTH)
RULE = Type("mean | either", Family.ENUM, options=("mean", "either"))
INTRINSICS = Type("Intrinsics", Family.OBJECT, cls=Intrinsics)
#: every name that the expressions below know: its type and value
KNOWN: dict[str, tuple[Type, Any]] = {
    "n": (INT, 7),
    "x": (FLOAT, 2.5),
    "h": (LENGTH, 0.010),
    "w": (LENGTH, 0.004),
    "f": (FORCE, 3.0),
    "t": (TIME, 2.0),
    "yes": (BOOL, True),
    "no": (BOOL, False),
    "s": (STR, "paper"),
    "rule": (RULE, "mean"),
    "steps": (LISTED, [0.001, 0.002]),
    "k": (INTRINSICS, SimpleNamespace(fx=500.0, fy=501.0, width=None)),
}


class Names:
    """A scope and an environment of the names above."""

    def resolve(self, parts: tuple[str, ...]) -> Symbol:
        if parts[0] not in KNOWN:
            raise Unresolved(0, "known names")
        return Symbol(Origin.KEY, parts[0], KNOWN[parts[0]][0], 1)

    def source(self, parts: tuple[str, ...]) -> tuple[Any, tuple[str, ...]]:
        return (lambda: KNOWN[parts[0]][1]), parts[1:]


def evaluate(text: str) -> tuple[Any, Type]:
    expression = parse(text)
    type_ = typecheck(expression, Names())
    return bind(expression, Names())(), type_


#: text -> value (SI) and type
VALUES: dict[str, tuple[Any, Type]] = {
    "1 + 2 * 3": (7, INT),
    "(1 + 2) * 3": (9, INT),
    "7 - 2 - 1": (4, INT),
    "8 / 4 / 2": (1.0, FLOAT),
    "-2 * -3": (6, INT),
    "- - 2": (2, INT),
    "1/2": (0.5, FLOAT),
    "n / 2": (3.5, FLOAT),
    "1e-3": (0.001, FLOAT),
    ".5": (0.5, FLOAT),
    "5 %": (0.05, FLOAT),
    "10 mm": (0.010, LENGTH),
    "10mm": (0.010, LENGTH),
    "10 mm + 1 cm": (0.020, LENGTH),
    "h - w": (0.006, LENGTH),
    "$h - ($h - $w)": (0.004, LENGTH),
    "-h": (-0.010, LENGTH),
    "2 * h": (0.020, LENGTH),
    "h / w": (2.5, FLOAT),
    "f / h": (300.0, quantity(KINDS["Stiffness"].dimension)),
    "h * w": (0.00004, quantity(KINDS["Area"].dimension)),
    "h / t": (0.005, quantity(KINDS["Speed"].dimension)),
    "1.5 N/mm * h": (15.0, FORCE),
    "1 / t": (0.5, quantity(KINDS["Frequency"].dimension)),
    "3 1/mm * h": (30.0, FLOAT),
    "10 mm / 2 s": (0.005, quantity(KINDS["Speed"].dimension)),
    "10 mm/s * t": (0.020, LENGTH),
    "h * h * h": (1e-6, quantity(KINDS["Volume"].dimension)),
    "f * t": (6.0, quantity(Dimension(1, 1, -1))),
    "abs(w - h)": (0.006, LENGTH),
    "min(h, w, 1 mm)": (0.001, LENGTH),
    "max(2, n)": (7, INT),
    "max(2, x)": (2.5, FLOAT),
    "sqrt(h * h)": (0.010, LENGTH),
    "sqrt(n + 2)": (3.0, FLOAT),
    "h > w": (True, BOOL),
    "h >= 10 mm": (True, BOOL),
    "n != 7": (False, BOOL),
    "n == 7.0": (True, BOOL),
    "h == w": (False, BOOL),
    "yes and no": (False, BOOL),
    "yes or no and no": (True, BOOL),
    "(yes or no) and no": (False, BOOL),
    "not no": (True, BOOL),
    "not yes or yes": (True, BOOL),
    "not h > w": (False, BOOL),
    "not not yes": (True, BOOL),
    "n > 3 and n < 9": (True, BOOL),
    "(n > 3) == yes": (True, BOOL),
    "s == 'paper'": (True, BOOL),
    's != "mean"': (True, BOOL),
    "rule == 'mean'": (True, BOOL),
    "rule == s": (False, BOOL),
    "steps.1": (0.002, LENGTH),
    "steps.0 + steps.1": (0.003, LENGTH),
    "k.fx / k.fy": (500 / 501, FLOAT),
    "true": (True, BOOL),
    "not false": (True, BOOL),
    "1 s > 999 ms": (True, BOOL),
    "180 deg": (math.pi, quantity(KINDS["Angle"].dimension)),
}


@pytest.mark.parametrize("text", VALUES)
def test_value_and_type(text: str) -> None:
    value, type_ = VALUES[text]
    found, found_type = evaluate(text)
    assert found == pytest.approx(value)
    assert type(found) is type(value) or isinstance(value, float)
    assert (found_type.family, found_type.dimension) == (type_.family, type_.dimension)


#: text with the wrong part marked -> code, part of the hint
ERRORS = {
    "«»": ("expression", "value is missing"),
    "n +«»": ("expression", "value is missing"),
    "n + «)»": ("expression", "value is missing"),
    "(n«»": ("expression", "add ')'"),
    "n «n»": ("expression", "operator"),
    "n «=» 2": ("expression", "'=='"),
    "n > 2 «&&» yes": ("expression", "'and'"),
    "yes «||» no": ("expression", "'or'"),
    "«!»yes": ("expression", "'not "),
    "n «^» 2": ("expression", "x * x"),
    "«{»n}": ("expression", "'$key'"),
    "steps«[»0]": ("expression", "'.0'"),
    "n ** 2": ("expression", ""),
    "1 < n «<» 9": ("expression", "a < b and b < c"),
    "n > 2 «==» yes": ("expression", "a < b and b < c"),
    "«m» + 1": ("name-unknown", "known names"),
    "«$m» + 1": ("name-unknown", "known names"),
    "k.«fz»": ("attribute-unknown", "fx"),
    "$k.«fz» > 1": ("attribute-unknown", "fx"),
    "n.«x»": ("attribute-unknown", "no parts"),
    "steps.«x»": ("attribute-unknown", "'len(steps)'"),
    "h + «1»": ("unit-missing", "'1 mm'"),
    "h > «2 N»": ("unit-mismatch", "mm"),
    "«h + f»": ("unit-mismatch", "one dimension"),
    "n + «1 mm»": ("unit-mismatch", "without a unit"),
    "max(h, «f»)": ("unit-mismatch", "one dimension"),
    "«sqrt(h)»": ("unit-mismatch", "multiply"),
    "«10 milli» > h": ("unit-unknown", "10 mm"),
    "not «n»": ("type-mismatch", "compare"),
    "yes and «n»": ("type-mismatch", "compare"),
    "«yes» + 1": ("type-mismatch", "number"),
    "«s» > 2": ("type-mismatch", "number"),
    "«s == n»": ("type-mismatch", "one type"),
    "rule == «'meen'»": ("option-unknown", "did you mean 'mean'?"),
    "«round»(n)": ("function-unknown", "abs, min, max, sqrt"),
    "«abs»(n, n)": ("expression", "number of values"),
    "max(«n»)": ("type-mismatch", "two values or more"),
    "abs(«)»": ("expression", "value is missing"),
    "n«;» n": ("expression", "expressions know"),
    "n if n else n": ("expression", ""),
    "'a«»": ("expression", ""),
    "«" + "(" * 60 + "»n": ("expression", "split"),
    "«" + "n+" * 150 + "»n": ("expression", "split"),
    "«" + " " * 2000 + "»n": ("expression", "node"),
}


@pytest.mark.parametrize("marked", ERRORS)
def test_errors_are_at_their_offset_with_a_hint(marked: str) -> None:
    code, hint = ERRORS[marked]
    with pytest.raises(ExpressionError) as caught:
        evaluate(marked.replace("«", "").replace("»", ""))
    error = caught.value
    assert error.code == code, error
    assert hint in error.hint
    if "«" in marked and len(marked) < 50 and not marked.startswith("'"):
        assert error.offset == marked.index("«")
        assert error.length == max(marked.index("»") - marked.index("«") - 1, 1)


def test_what_stands_first_decides() -> None:
    """`and` and `or` do not ask what they need not know."""
    asked = []

    class Asking(Names):
        def source(self, parts: tuple[str, ...]) -> tuple[Any, tuple[str, ...]]:
            return (lambda: (asked.append(parts[0]), KNOWN[parts[0]][1])[1]), parts[1:]

    for text in ("no and yes", "yes or no"):
        expression = parse(text)
        typecheck(expression, Asking())
        bind(expression, Asking())()
    assert asked == ["no", "yes"]


@pytest.mark.parametrize("text", ["steps.7", "k.width + 1"])
def test_an_item_or_part_that_is_not_there_says_so(text: str) -> None:
    with pytest.raises(Absent, match=r"has no value|is none"):
        evaluate(text)


@given(st.text(st.sampled_from("nxhf $.()+-*/<>=!'\"0123456789msN%andort,[]"), max_size=40))
def test_any_text_has_a_type_or_an_error_inside_it(text: str) -> None:
    error = None
    try:
        expression = parse(text)
        typecheck(expression, Names())
    except ExpressionError as found:
        error = found
    if error is not None:
        assert 0 <= error.offset <= len(text)
        assert error.hint
        return
    for name in names(expression):
        assert text[name.offset : name.offset + name.length].removeprefix("$") == ".".join(name.parts)


leaves = st.sampled_from(["n", "x", "2", "0.5", "3"])
arithmetic = st.recursive(
    leaves,
    lambda inner: (
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})")
        | inner.map(lambda t: f"(-{t})")
        | st.tuples(st.sampled_from(["min", "max"]), inner, inner).map(lambda t: f"{t[0]}({t[1]}, {t[2]})")
    ),
    max_leaves=12,
)


@given(arithmetic)
def test_arithmetic_is_that_of_python(text: str) -> None:
    known = {name: value for name, (_, value) in KNOWN.items()} | {"min": min, "max": max}
    try:
        expected = eval(text, {"__builtins__": {}}, known)
    except ZeroDivisionError:
        with pytest.raises(InvalidInput, match="is no finite number"):
            evaluate(text)
        return
    assert evaluate(text)[0] == pytest.approx(expected)


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
def test_the_units_that_messages_name_can_be_written(kind: Kind) -> None:
    for unit in (kind.unit, kind.si_unit):
        text = f"5 {unit}"
        assert not reads_as_expression(Scalar(text, False, Mark("t.yaml", 1, 1)))
        assert parse(text).type == quantity(kind.dimension)
