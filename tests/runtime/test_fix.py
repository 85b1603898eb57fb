"""`check --fix`: files of the older form, rewritten in place."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from stretch_bt.cli.app import app
from stretch_bt.errors import InvalidInput
from stretch_bt.runtime.check import check
from stretch_bt.runtime.fix import fix_tree
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
#: a file with behaviours of other packages, whose arguments may be called as words beside a node are
BEHAVIOURS = """\
format: stretch-tree/1
imports: {waits: their.Waits, own: own_nodes}
trees:
  main:
    sequence:
      - waits: {timeout: 3.0}
      - own.Waits: {timeout: 3.0}
      - own.waits: {timeout: 3 s}
"""
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


#: declarations of `frame` and `contact`, each with its type alone -> what is left of them
BARE = {
    "keys: {frame: DepthFrame, contact: {type: Contact}}\n": "",
    "keys:\n  frame: {type: DepthFrame}\n  contact:\n    type: Contact\n": "",
    "keys:\n  contact:\n    type: Contact\n\n  frame: {type: DepthFrame}\n": "",
    "keys:\n  contact: {type: Contact}\n  frame:\n    type: DepthFrame  # a view\n": "keys:\n  frame:\n    type: DepthFrame  # a view\n",
    "keys: {frame: {type: DepthFrame, doc: a view}, contact: {type: Contact}}\n": "keys: {frame: {type: DepthFrame, doc: a view}}\n",
    "keys: {frame: &a {type: DepthFrame}, contact: Contact, other: *a}\n": "keys: {frame: &a {type: DepthFrame}, other: *a}\n",
}


@pytest.mark.parametrize("keys", BARE)
def test_a_declaration_of_a_type_alone_goes_however_it_is_written(keys: str, tmp_path: Path) -> None:
    path = tmp_path / "tree.yaml"
    head, tail = FIXED.partition("keys:\n")[0], FIXED[FIXED.index("trees:\n") : FIXED.index("  look:\n")]
    steps = "- capture\n      - segment_contact\n      - track_height: {height: $top}"
    tail = tail.replace("- look: {top}", steps).replace("      - check: not low\n", "")
    path.write_text(head + keys + tail)
    assert fix_tree(path) == []
    assert path.read_text() == head + BARE[keys] + tail


def test_a_name_that_would_clash_is_left_and_told_at_its_place(tmp_path: Path) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(TREE.replace("low: {type: bool", "depth: {type: bool"))
    [left] = fix_tree(path)
    assert (left.line, left.column, left.code) == (17, 25, "retired")
    assert "rename one of them" in left.hint
    assert "$params.depth" in path.read_text()


@pytest.mark.parametrize("text", ["format: stretch-tree/1\n", "format: stretch-scene/1\nwhile: a\n", FIXED])
def test_what_needs_no_change_stays_as_it_is(tmp_path: Path, text: str) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(text)
    assert fix_tree(path) == []
    assert path.read_text() == text


def test_an_alias_is_respelt_once() -> None:
    old = "sequence:\n  - capture: &a {frame: $frame, n: $params.n}\n  - capture: *a\n"
    assert respell(old).text == "sequence:\n  - capture: &a {frame, n}\n  - capture: *a\n"


TEXT = "format: stretch-tree/1\ntrees: {main: {while: 'true', wait: {duration: 1 s}}}\n"
#: what keeps a file from being read as a tree
WRONG: dict[str, Callable[[Path], object]] = {
    "missing": lambda path: None,
    "a folder": Path.mkdir,
    "a link to itself": lambda path: path.symlink_to(path.name),
    "another encoding": lambda path: path.write_bytes(TEXT.replace("1 s", "1 s # \xe9").encode("latin-1")),
    "a NUL": lambda path: path.write_text(TEXT + "\0"),
    "no YAML": lambda path: path.write_text(TEXT + "a: ["),
    "a list": lambda path: path.write_text("- format: stretch-tree/1\n"),
    "a tag": lambda path: path.write_text("format: stretch-tree/1\ntrees: !!python/object:os.system {main: 3}\n"),
    "a key that is a list": lambda path: path.write_text("format: stretch-tree/1\ntrees: {main: {}}\n? [a]\n: b\n"),
    "an anchor within itself": lambda path: path.write_text("format: stretch-tree/1\ntrees: &a {main: *a}\n"),
    "too deep": lambda path: path.write_text(f"format: stretch-tree/1\nx: {'[' * 999}{']' * 999}\n"),
}


@pytest.mark.parametrize("what", WRONG)
@pytest.mark.parametrize("name", ["tree.yaml", "./tree.yaml", "tree"])
def test_a_file_that_is_no_tree_is_told_as_the_check_tells_it(
    what: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    WRONG[what](Path(name))
    plain, fixed = (CliRunner().invoke(app, ["check", name, "--json", *more]) for more in ((), ("--fix",)))
    assert (fixed.exit_code, json.loads(fixed.stdout)) == (plain.exit_code, json.loads(plain.stdout))
    assert fixed.exit_code == 2


def test_a_name_that_no_file_can_have_is_told_as_the_check_tells_it() -> None:
    fixed = CliRunner().invoke(app, ["check", "x" * 5000 + ".yaml", "--json", "--fix"])
    assert (fixed.exit_code, json.loads(fixed.stdout)[0]["code"]) == (2, "file-unreadable")


@pytest.mark.parametrize("name", ["tree.yaml", "./tree.yaml", "tree"])
def test_a_file_is_fixed_however_it_is_named(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).write_text(TEXT)
    fixed = CliRunner().invoke(app, ["check", name, "--fix"])
    assert (fixed.exit_code, Path(name).read_text()) == (0, TEXT.replace("while", "guard"))


def test_a_file_that_cannot_be_written_stays_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(TEXT)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(InvalidInput, match=r"cannot be written .No space left"):
        fix_tree(path)
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("tree.yaml", TEXT)]


TEXTS = """\
format: stretch-tree/1
params: {level: {type: str, default: high}}
keys:
  c: {type: str, default: b}   # a text
  a: {type: str, default: z}
  mode: {type: slow | fast, default: fast}
  n: {type: int, default: 0}
trees:
  main:
    sequence:
      - set: {%s}
      - repeat: {times: 2, do: {set: {n: n + 1}}}
      - check: "c == mode or n > 0 or a == level"
    finally: {set: {c: done}}
"""
#: values of a `set` in an older file, and how each is written now
GIVEN = {
    "c: x": """c: "'x'\"""",
    "c: x, n: n + 1, mode: slow": """c: "'x'", n: n + 1, mode: "'slow'\"""",
    "$c: x": """$c: "'x'\"""",
    "c: two words": """c: "'two words'\"""",
    "c: 3": """c: "'3'\"""",
    "c: true": """c: "'true'\"""",
    "c: 'x'": """c: "'x'\"""",
    "c: ''": """c: "''\"""",
    "c: 5 mm": """c: "'5 mm'\"""",
    "c: it's": """c: '"it''s"'""",
    "c: 'say \"x\"'": """c: '''say "x"'''""",
    # a name, an expression, a text in quotes of its own, absence: all as they are
    "c: a": "c: a",
    "c: level": "c: level",
    "c: $a": "c: $a",
    """c: "'x'\"""": """c: "'x'\"""",
    "c: none": "c: none",
    "n: n + 1": "n: n + 1",
}


@pytest.mark.parametrize("given", GIVEN)
def test_a_text_in_a_set_that_is_no_name_gets_quotes_of_its_own(given: str, tmp_path: Path) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(TEXTS % given)
    assert all(d.severity == "warning" for d in fix_tree(path))  # of what is a name now
    assert f"- set: {{{GIVEN[given]}}}\n" in path.read_text()
    assert """finally: {set: {c: "'done'"}}\n""" in path.read_text()
    assert [d for d in check(path) if d.severity == "error"] == []
    fixed = path.read_text()
    assert fix_tree(path) == []
    assert path.read_text() == fixed


def test_arguments_of_behaviours_stay_in_their_braces():
    assert respell(BEHAVIOURS).text == BEHAVIOURS.replace(
        "- own.waits: {timeout: 3 s}", "- timeout: 3 s\n        own.waits: {}"
    )


#: values of a key of text in an older file -> whether a warning says that the value is read as a name now
NAMED = {"c: a": True, "c: level": True, "$c: a": True, "c: $a": False, "c: x": False, "n: n": False, "c: none": False}


@pytest.mark.parametrize("given", NAMED)
def test_a_text_that_is_read_as_a_name_now_is_told_at_its_place(given: str, tmp_path: Path) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(TEXTS % given)
    left = fix_tree(path)
    assert [d.severity for d in left] == ["warning"] * NAMED[given]
    for found in left:
        word = given.rpartition(" ")[2]
        assert path.read_text().splitlines()[found.line - 1][found.column - 1 :].startswith(word)
        assert found.hint == f"write \"'{word}'\" if the text is meant, '${word}' if the name is"
    assert fix_tree(path) == [], "a file of the present form says what it means"


#: old text -> new
BLOCKS = {
    "sequence:\n  - press:\n      depth: 5 mm\n      guard:\n        - arm.force < 4 N\n": (
        "sequence:\n  - guard:\n      - arm.force < 4 N\n    press:\n      depth: 5 mm\n"
    ),
    "sequence:\n  - press:\n      guard:\n        that: arm.force < 4 N\n        name: soft\n      depth: 5 mm\n": (
        "sequence:\n  - guard:\n      that: arm.force < 4 N\n      name: soft\n    press:\n      depth: 5 mm\n"
    ),
    "sequence:\n  - press:\n      guard:\n        that: arm.force < 4 N\n#       name: soft\n        else: hard\n      depth: 5 mm\n": (
        "sequence:\n  - guard:\n      that: arm.force < 4 N\n      #       name: soft\n      else: hard\n    press:\n      depth: 5 mm\n"
    ),
    "imports: {log: lib/log.yaml}\ndevices: {guard: ForceSensor}\n": None,
    "sequence:\n  - repeat: {times: 2, do: {wait: {duration: 1 s}}, collect: {name: $n}}\n": None,
}


@pytest.mark.parametrize("old", BLOCKS)
def test_words_in_blocks_move_as_blocks_and_names_of_ones_own_stay(old: str) -> None:
    assert respell(old).text == (BLOCKS[old] or old)
