"""`check --fix`: files of the older form, rewritten in place."""

from pathlib import Path

import pytest

from stretch_bt.run.check import check
from stretch_bt.run.fix import fix_tree
from stretch_bt.tree.respell import respell

#: a place of the older form -> the present one
PLACES = {
    "sequence:\n  - press: {depth: $params.deep, timeout: 5 s}\n": "sequence:\n  - timeout: 5 s\n    press: {depth: $deep}\n",
    "sequence: [wait: {duration: 1 s, name: a}]\n": "sequence: [{name: a, wait: {duration: 1 s}}]\n",
    "sequence: [{wait: {name: a, duration: 1 s}, log: x}]\n": "sequence: [{name: a, wait: {duration: 1 s}, log: x}]\n",
    "sequence:\n  - wait:   # here\n      name: a\n      duration: 1 s\n": "sequence:\n  - name: a\n    wait:   # here\n      duration: 1 s\n",
    "sequence:\n  - wait:\n      duration: 1 s\n      name: a\n": "sequence:\n  - name: a\n    wait:\n      duration: 1 s\n",
    "while: arm.force < params.most\nsequence: [retract]\n": "guard: arm.force < most\nsequence: [retract]\n",
    "sequence: [check: {that: a > params.b, name: c}]\n": "sequence: [check: {that: a > b, name: c}]\n",
    "sequence:\n  - capture: {frame: $frame, camera: left}  # look\n": "sequence:\n  - capture: {frame, camera: left}  # look\n",
    "sequence:\n  - capture:\n      frame: $frame\n": "sequence:\n  - capture:\n      frame:\n",
    "until: {that: done, max: 3, do: {set: {x: $x}}, name: a}\n": "name: a\nuntil: {that: done, max: 3, do: {set: {x: $x}}}\n",
    "sequence: [set: {name: params.a}]\n": "sequence: [set: {name: a}]\n",
}
TREE = """\
format: stretch-tree/1
doc: Look once.   # params.depth stays here
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
scene: water_balloon
params:
  depth: {type: Length, default: 5 mm}
keys:
  frame: DepthFrame
  contact: Contact     # kept for its comment
  low: {type: bool, default: false}
trees:
  main:
    out: {top: Length}
    sequence:
      - approach
      - press: {depth: $params.depth, timeout: 9 s}
      - look: {top: $top}
      - check: not low
  look:
    out: {top: Length}
    keys: {frame: DepthFrame, contact: Contact}
    sequence:
      - capture: {frame: $frame}
      - segment_contact: {frame: $frame, contact: $contact}
      - track_height: {frame: $frame, contact: $contact, height: $top}
"""
FIXED = """\
format: stretch-tree/1
doc: Look once.   # params.depth stays here
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
scene: water_balloon
params:
  depth: {type: Length, default: 5 mm}
keys:
  contact: Contact     # kept for its comment
  low: {type: bool, default: false}
trees:
  main:
    out: {top: Length}
    sequence:
      - approach
      - timeout: 9 s
        press: {depth}
      - look: {top}
      - check: not low
  look:
    out: {top: Length}
    sequence:
      - capture: {frame}
      - segment_contact: {frame, contact}
      - track_height: {frame, contact, height: $top}
"""


@pytest.mark.parametrize("old", PLACES)
def test_a_place_is_respelt(old: str) -> None:
    assert respell(old).text == PLACES[old]
    assert respell(PLACES[old]).text == PLACES[old]


def test_a_file_is_rewritten_with_its_comments(tmp_path: Path) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(TREE)
    assert fix_tree(path) == []
    assert path.read_text() == FIXED
    assert [d for d in check(path) if d.severity == "error"] == []
    assert fix_tree(path) == []
    assert path.read_text() == FIXED


def test_a_name_that_would_clash_is_left_and_told_at_its_place(tmp_path: Path) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(TREE.replace("low: {type: bool", "depth: {type: bool"))
    [left] = fix_tree(path)
    assert (left.line, left.column, left.code) == (17, 25, "retired")
    assert "rename one of them" in left.hint
    assert "$params.depth" in path.read_text()


@pytest.mark.parametrize("text", ["a: [", "format: stretch-tree/1\n", FIXED])
def test_what_needs_no_change_stays_as_it_is(tmp_path: Path, text: str) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(text)
    assert fix_tree(path) == []
    assert path.read_text() == text
