"""Shipped trees are short enough to be read as the algorithms that they are."""

from itertools import combinations
from pathlib import Path

import pytest

from stretch_bt.tree.shared import shipped

MOST = {
    "palpate_stiffness": 80,
    "palpate_active": 80,
    "reconstruct": 75,
    "form_cookie": 95,
    "form_cookie_fast": 110,
    "characterize": 65,
    "contact_sensitivity": 66,
    "watch_contact": 30,
}
FILES = [*shipped("").glob("*.yaml"), *shipped("lib").glob("*.yaml")]


def lines(path: Path) -> list[str]:
    """Return the lines of a file without lines that are comments alone."""
    return [line.strip() for line in path.read_text("utf-8").splitlines() if not line.strip().startswith("#")]


@pytest.mark.parametrize("tree", MOST)
def test_a_task_is_read_on_a_page(tree: str) -> None:
    assert len(lines(shipped(f"{tree}.yaml"))) <= MOST[tree]


def test_every_task_has_its_bound_and_the_libraries_one_together() -> None:
    assert {path.stem for path in shipped("").glob("*.yaml")} == set(MOST)
    assert sum(len(lines(path)) for path in shipped("lib").glob("*.yaml")) <= 200
    assert max(len(line) for path in FILES for line in path.read_text("utf-8").splitlines()) <= 120


@pytest.mark.parametrize(("one", "other"), list(combinations(FILES, 2)), ids=lambda path: path.stem)
def test_no_two_files_repeat_more_than_ten_lines_of_a_body(one: Path, other: Path) -> None:
    """Lines in a row, blank ones aside."""

    def runs(path: Path) -> set[tuple[str, ...]]:
        text = path.read_text("utf-8")
        body = [line.strip() for line in text[text.index("sequence:") :].splitlines() if line.strip()]
        return {tuple(body[i : i + 11]) for i in range(len(body) - 10)}

    assert not runs(one) & runs(other)
