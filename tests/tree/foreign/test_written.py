"""Which values of Python a tree file can write, and that they become what the annotation says and return."""

from collections.abc import Callable, Sequence
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Literal, Optional, Union

import py_trees
import pytest
from py_trees.common import Status

from stretch_bt.tree.foreign.written import mentions_behaviour, written_as
from stretch_bt.units import Length


class Colour(Enum):
    RED = 1
    BLUE = 2


@pytest.mark.parametrize(
    ("annotation", "written", "made"),
    [
        (int, 3, 3),
        (float, 3, 3.0),
        (bool, True, True),
        (str, "battery", "battery"),
        (Length, 0.01, 0.01),
        (Annotated[int, "pixels"], 3, 3),
        (Path, "a/b", Path("a/b")),
        (Colour, "BLUE", Colour.BLUE),
        (list[Status], ["SUCCESS", "RUNNING"], [Status.SUCCESS, Status.RUNNING]),
        (tuple[float, float], [1, 2], (1.0, 2.0)),
        (set[str], ["a"], {"a"}),
        (Sequence[int], [1, 2], [1, 2]),
        (int | float, 3, 3.0),
        (Optional[Colour], None, None),  # noqa: UP045
        (Colour | None, "RED", Colour.RED),
        (Union[float, Callable[[], float]], 2.0, 2.0),  # noqa: UP007
        (Literal["a", "b"], "a", "a"),
        (Any, "text", "text"),
        (Any | Callable[[], Any], 3, 3),
    ],
    ids=str,
)
def test_a_value_becomes_what_the_annotation_says(annotation, written, made):
    found = written_as(annotation)
    assert found.made(written) == made
    assert type(found.made(written)) is type(made)
    assert found.back(made) == (list(written) if isinstance(made, set | tuple) else written)


@pytest.mark.parametrize(
    "annotation",
    [
        Callable[[], bool],
        dict[str, float],
        tuple[int, str],
        py_trees.blackboard.Client,
        list[object],
        "Unknown",
        bytes,
        list,
    ],
    ids=str,
)
def test_what_no_file_can_write_is_none(annotation):
    assert written_as(annotation) is None


@pytest.mark.parametrize(
    ("annotation", "mentions"),
    [
        (py_trees.behaviour.Behaviour, True),
        (list[py_trees.behaviour.Behaviour] | None, True),
        (py_trees.composites.Composite, True),
        (Callable[[], bool], False),
        (int, False),
        ("Behaviour", False),
    ],
    ids=str,
)
def test_an_annotation_that_asks_for_behaviours_is_seen(annotation, mentions):
    assert mentions_behaviour(annotation) is mentions
