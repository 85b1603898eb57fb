"""The types of ports, keys and expressions: from Python, by name, and which of them fits which."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

import numpy as np
import numpy.typing as npt
import pytest
from typing_extensions import TypeAliasType

from stretch_bt.tree.types import (
    ANY,
    BOOL,
    FLOAT,
    INT,
    STR,
    Family,
    Type,
    attributes,
    from_annotation,
    named,
    quantity,
    unaliased,
)
from stretch_bt.units import DIMENSIONLESS, KINDS, Force, Length


@dataclass
class Ball:
    """Something that a port may carry."""

    radius: Length
    count: int
    points: np.ndarray
    _secret: float = 0.0

    @property
    def size(self) -> Length:
        """Its diameter."""
        return 2 * self.radius

    @property
    def shape(self) -> tuple[int, ...]:
        """Its shape."""
        return (1,)


class SmallBall(Ball):
    """A kind of it."""


LENGTH = quantity(KINDS["Length"].dimension)
LENGTHS = Type("list[Length]", Family.LIST, item=LENGTH)
BALL = from_annotation(Ball)
RULE = from_annotation(Literal["mean", "either"])

ANNOTATIONS = {
    "int": (int, INT),
    "float": (float, FLOAT),
    "bool": (bool, BOOL),
    "str": (str, STR),
    "Length": (Length, LENGTH),
    "optional": (Length | None, LENGTH),
    "annotated": (Annotated[int, "words"], INT),
    "list": (list[Length], LENGTHS),
    "tuple": (tuple[Length, ...], LENGTHS),
    "sequence": (Sequence[Length], LENGTHS),
}


@pytest.mark.parametrize("name", ANNOTATIONS)
def test_annotations_of_python(name: str) -> None:
    annotation, type_ = ANNOTATIONS[name]
    assert from_annotation(annotation) == type_


@pytest.mark.parametrize("annotation", [Any, dict[str, int], int | str, None, "Length"])
def test_what_the_language_does_not_have_is_refused(annotation: Any) -> None:
    with pytest.raises(TypeError, match="not a type of the tree language"):
        from_annotation(annotation)


NAMES = {
    "Length": LENGTH,
    " Length ": LENGTH,
    "int": INT,
    "list[Length]": LENGTHS,
    "list[list[int]]": Type("list[list[int]]", Family.LIST, item=Type("list[int]", Family.LIST, item=INT)),
    "Ball": BALL,
    "length": None,
    "list[length]": None,
    "list[]": None,
    "list": None,
    "": None,
    "list[" * 500 + "int" + "]" * 500: None,
}


Item = TypeVar("Item")
Reach = TypeAliasType("Reach", Length)
Row = TypeAliasType("Row", list[Item], type_params=(Item,))
Rows = TypeAliasType("Rows", Row[Reach])


def test_an_alias_is_the_type_that_it_stands_for() -> None:
    """As one of a `type` statement is, or NDArray since numpy 2.5."""
    assert from_annotation(Reach) == from_annotation(Length)
    assert from_annotation(Rows) == from_annotation(list[Reach]) == from_annotation(list[Length])
    array = unaliased(npt.NDArray[np.uint8])
    assert get_origin(array) is np.ndarray
    assert get_args(array)[1] == np.dtype[np.uint8]


@pytest.mark.parametrize("text", NAMES, ids=lambda text: text[:20])
def test_names_of_files(text: str) -> None:
    assert named(text, {"Ball": Ball}) == NAMES[text]


def test_words_to_choose_from() -> None:
    assert named("mean|either", {}) == named(" mean | either ", {}) == from_annotation(Literal["mean", "either"])
    for text in ("mean |", "mean | mean", "Mean | either", "a b | c", "list[a | b]", "2 | 3", "|"):
        assert named(text, {}) is None, text


#: (the type asked for, the type given, whether it is accepted)
FITS = [
    (LENGTH, LENGTH, True),
    (LENGTH, quantity(KINDS["Force"].dimension), False),
    (LENGTH, FLOAT, False),
    (LENGTH, INT, False),
    (FLOAT, LENGTH, False),
    (FLOAT, INT, True),
    (INT, FLOAT, False),
    (INT, INT, True),
    (BOOL, INT, False),
    (INT, BOOL, False),
    (FLOAT, BOOL, False),
    (STR, RULE, True),
    (RULE, STR, False),
    (RULE, from_annotation(Literal["mean"]), True),
    (RULE, from_annotation(Literal["mean", "none"]), False),
    (LENGTHS, LENGTHS, True),
    (LENGTHS, LENGTH, False),
    (LENGTH, LENGTHS, False),
    (from_annotation(list[float]), from_annotation(list[int]), True),
    (from_annotation(list[int]), from_annotation(list[float]), False),
    (BALL, from_annotation(SmallBall), True),
    (from_annotation(SmallBall), BALL, False),
    (BALL, LENGTH, False),
    (LENGTH, BALL, False),
    (BALL, ANY, True),
    (ANY, LENGTH, True),
]


@pytest.mark.parametrize(("wanted", "given", "fits"), FITS)
def test_what_fits(wanted: Type, given: Type, fits: bool) -> None:
    assert wanted.accepts(given) is fits


def test_expressions_may_read_what_has_a_type() -> None:
    found = attributes(Ball)
    assert {name: str(type_) for name, type_ in found.items()} == {
        "radius": "Length",
        "count": "int",
        "points": "ndarray",
        "size": "Length",
        "shape": "list[int]",
    }


def test_a_quantity_without_a_dimension_is_a_number() -> None:
    assert quantity(DIMENSIONLESS) is FLOAT
    assert from_annotation(Force).kind is KINDS["Force"]
    assert FLOAT.kind is None
