"""Shipped trees that a file calls like nodes, without an import."""

from pathlib import Path

import pytest

from stretch_bt.tree.program import load_program

TREE = """\
format: stretch-tree/1
devices: {%s}
trees:
  main:
    sequence:
      - approach: {speed: 5 mm/s}
      - %s
"""


@pytest.fixture
def load(tmp_path: Path):
    def loaded(devices: str, then: str):
        (tmp_path / "tree.yaml").write_text(TREE % (devices, then))
        return load_program(tmp_path / "tree.yaml")

    return loaded


@pytest.mark.parametrize("then", ["press: {depth: 3 mm}", "press_gently: {depth: 3 mm}"])
def test_devices_are_found_by_their_kind_whatever_they_are_called(load, then: str) -> None:
    assert load("ur: Arm, watching: DepthCamera", then).diagnostics == []


def test_a_device_that_is_missing_is_told_once_and_where_the_tree_is_called(load) -> None:
    [found] = load("arm: Arm", "press: {depth: 3 mm}").diagnostics
    assert (found.line, found.column, found.code) == (6, 9, "device-undeclared")
    assert found.message.startswith("in 'approach': ")
    assert "devices: {camera: DepthCamera}" in found.hint


def test_only_what_is_called_is_read(load) -> None:
    trees = {body.signature.name for body in load("arm: Arm, camera: DepthCamera", "retract").bodies.values()}
    assert trees == {"main", "approach", "feel_touch"}


def test_a_tree_of_the_same_name_would_hide_it(load, tmp_path: Path) -> None:
    (tmp_path / "tree.yaml").write_text(
        "format: stretch-tree/1\ntrees:\n  main: {sequence: [approach]}\n  approach: {sequence: [wait: {duration: 1 s}]}\n"
    )
    [found] = load_program(tmp_path / "tree.yaml").errors
    assert (found.code, found.line) == ("name", 4)
    assert "shipped tree" in found.message


HIDDEN = """\
format: stretch-tree/1
devices: {arm: Arm}
trees:
  main:
    sequence:
      - press: {depth: 5 mm}
      - plan_press: {deflection: 1.5 mm, next}
      - stiffness_at: {deflection: 1.5 mm, stiffness}
"""


def test_what_nodes_read_and_nothing_wrote_is_an_error_at_each_of_them(tmp_path: Path) -> None:
    (tmp_path / "tree.yaml").write_text(HIDDEN)
    found = [(d.line, d.message.split(" (")[0]) for d in load_program(tmp_path / "tree.yaml").errors]
    assert found == [
        (6, "'press' needs 'touch'"),
        (7, "'plan_press' needs 'candidates'"),
        (7, "'plan_press' needs 'felt'"),
        (8, "'stiffness_at' needs 'felt'"),
    ]
