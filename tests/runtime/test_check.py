"""Seeded mistakes: each is found by `check` at its place, alone, with a hint that is right."""

import re
import textwrap
from pathlib import Path
from typing import Any

import pytest
import yaml

from stretch_bt import check, run
from stretch_bt.errors import FileError, MocksError
from stretch_bt.hardware import cell as cells

TABLES = Path(__file__).parents[1] / "mistakes"
MISTAKES = [
    pytest.param(entry, id=f"{table.stem}: {entry['name']}")
    for table in sorted(TABLES.glob("*.yaml"))
    for entry in yaml.safe_load(table.read_text("utf-8"))
]
#: what the mocks files of the tables are for
TREE = """
format: stretch-tree/1
devices: {arm: Arm, camera: DepthCamera}
keys: {height: {type: Length, default: 0 mm}}
trees:
  main:
    guard: arm.force < 5 N
    sequence: [{name: press, lower: {by: 1 mm}}, look: {height: $height}, {name: press, lower: {by: 2 mm}}]
    finally: [retract: {clearance: 20 mm}]
  look:
    out: {height: Length}
    keys: {frame: DepthFrame, contact: Contact}
    sequence:
      - capture: {frame: $frame}
      - segment_contact: {frame: $frame, contact: $contact}
      - track_height: {frame: $frame, contact: $contact, height: $height}
"""
MARKED = re.compile("«(.*?)»", re.DOTALL)


def tree_text(entry: dict[str, Any]) -> str:
    """Return a tree file with the body of main, and what else the entry gives."""
    body = textwrap.indent(entry["body"].strip(), "    ")
    trees = textwrap.indent(entry.get("trees", "").strip(), "  ")
    return f"format: stretch-tree/1\n{entry.get('head', '').strip()}\ntrees:\n  main:\n{body}\n{trees}\n"


def written(entry: dict[str, Any]) -> dict[str, str]:
    """Return the files of an entry by name, with the marks; the first is the one to check."""
    text = entry["file"] if "file" in entry else tree_text(entry)
    if "stretch-mocks" in text:
        return {"mocks.yaml": text, "tree.yaml": TREE, **entry.get("files", {})}
    return {"tree.yaml": text, **entry.get("files", {})}


def place(files: dict[str, str]) -> tuple[str, int, int, str]:
    """Return the file, line, column and text that the mark encloses."""
    [(name, text)] = [(name, text) for name, text in files.items() if MARKED.search(text)]
    match = MARKED.search(text)
    assert match is not None
    start = match.start()
    return name, text.count("\n", 0, start) + 1, start - (text.rfind("\n", 0, start) + 1) + 1, match[1]


def write(folder: Path, files: dict[str, str]) -> Path:
    """Write files without their marks and return the path of the first."""
    for name, text in files.items():
        (folder / name).write_text(MARKED.sub(r"\1", text), encoding="utf-8")
    return folder / next(iter(files))


def corrected(files: dict[str, str], fix: Any, hint: str) -> dict[str, str]:
    """Return the files as the hint wants them."""
    if isinstance(fix, dict):
        name = place(files)[0]
        text = MARKED.sub(r"\1", files[name])
        for old, new in fix.items():
            assert old in text, f"{old!r} is not in {name}"
            text = text.replace(old, new, 1)
        return {**files, name: text}
    quoted = re.search(r"'((?:[^']|'(?=\w))+)'", hint)
    assert quoted, f"the hint quotes nothing to write: {hint}"
    return {name: MARKED.sub(lambda _: quoted[1], text) for name, text in files.items()}


@pytest.mark.parametrize("entry", MISTAKES)
def test_each_mistake_is_found_at_its_place_with_a_hint_that_is_right(entry, tmp_path):
    files = written(entry)
    name, line, column, _ = place(files)
    path = write(tmp_path, files)
    severity = entry.get("severity", "error")
    found = [d for d in check([path]) if d.severity in ("error", severity)]
    main = next((d for d in found if d.code == entry["code"]), None)
    said = "\n".join(str(d) for d in found) or "nothing was found"
    assert main is not None, said
    assert (Path(main.file).name, main.line, main.column) == (name, line, column), said
    assert entry["hint"] in main.hint, said
    others = sorted(d.code for d in found if d is not main)
    assert others == sorted(entry.get("also", [])), said
    if "fix" in entry:
        again = write(tmp_path, corrected(files, entry["fix"], main.hint))
        left = [d for d in check([again]) if d.severity == "error"]
        assert left == [], f"after the correction by {main.hint!r}: {left}"


def is_harmless(entry: dict[str, Any]) -> bool:
    """Whether a run may begin all the same, or has no file to begin with."""
    return entry["code"] in ("file-missing", "tree-wrong") or entry.get("severity") == "warning"


OPTIONS = {"stretch-tree": "tree", "stretch-mocks": "mocks", "stretch-scene": "scene", "stretch-cell": "cell"}


@pytest.mark.parametrize("entry", [p for p in MISTAKES if not is_harmless(p.values[0])])
def test_no_mistake_reaches_a_device(entry, tmp_path, monkeypatch):
    """A run refuses what `check` refuses, before it opens a device or begins a record."""

    def opened(*_: Any, **__: Any) -> None:
        raise AssertionError("a device was opened")

    monkeypatch.setattr(cells, "open_cell", opened)
    path = write(tmp_path, written(entry))
    kind = next((OPTIONS[f] for f in OPTIONS if f in path.read_text("utf-8")), "tree")
    options: dict[str, Any] = {} if kind == "tree" else {kind: path}
    tree = path if kind == "tree" else tmp_path / "tree.yaml" if kind == "mocks" else "watch_contact"
    with pytest.raises(FileError) as caught:
        run(tree, out=tmp_path / "record", **options)
    assert any(d.code == entry["code"] for d in caught.value.diagnostics) or kind == "mocks"
    assert not (tmp_path / "record").exists()


def test_there_are_sixty_mistakes_and_more_of_every_kind_of_file():
    assert len(MISTAKES) > 200
    assert {param.id.partition(":")[0] for param in MISTAKES} == {"trees", "mocks", "scenes", "cells"}


def test_a_tree_is_deep_at_most_a_hundred(tmp_path):
    """However deep: by nesting within the limit of YAML, and by calls."""
    calls = "".join(f"  t{i}: {{sequence: [t{i + 1}]}}\n" for i in range(120))
    path = tmp_path / "tree.yaml"
    path.write_text(
        f"format: stretch-tree/1\ntrees:\n  main: {{sequence: [t0]}}\n{calls}  t120: {{sequence: [fail: no]}}\n"
    )
    [found] = check(path)
    assert (found.code, found.hint) == ("depth", "flatten nested composites")


def test_a_tree_has_ten_thousand_nodes_at_most(tmp_path):
    calls = "".join(f"  t{i}: {{sequence: [t{i + 1}, t{i + 1}]}}\n" for i in range(40))
    path = tmp_path / "tree.yaml"
    path.write_text(
        f"format: stretch-tree/1\ntrees:\n  main: {{sequence: [t0]}}\n{calls}  t40: {{sequence: [fail: no]}}\n"
    )
    [found] = check(path)
    assert found.code == "size"


def test_every_mistake_of_a_file_is_found_in_one_pass(tmp_path):
    path = tmp_path / "tree.yaml"
    path.write_text(
        """
format: stretch-tree/1
devices: {arm: Arm, camera: DepthCamera}
keys: {h: Length, f: DepthFrame}
trees:
  main:
    guard: arm.forse < 5 N
    sequence:
      - lower: {bye: 3 mm}
      - lowr: {by: 3 mm}
      - lower: {by: 3}
      - lower: {by: 300 mm}
      - capture: {frame: $g}
      - check: h > 3 mm
      - until: {that: h > 3 N, do: [sub]}
  sub: {sequence: [sub]}
"""
    )
    found = [(d.line, d.code) for d in check(path)]
    assert found == [
        (7, "name-unknown"),
        (9, "port-unknown"),
        (10, "node-unknown"),
        (11, "unit-missing"),
        (12, "out-of-bounds"),
        (14, "read-before-write"),
        (15, "unbounded-loop"),
        (16, "recursion"),
    ]


def test_every_mistake_of_a_mocks_file_is_found_in_one_pass_those_against_its_tree_too(tmp_path):
    (tmp_path / "tree.yaml").write_text(TREE)
    path = tmp_path / "mocks.yaml"
    path.write_text(
        """
format: stretch-mocks/1
tree: tree.yaml
mocks:
  - {match: "main/press[0]", after: 1}
  - {match: main/loock}
  - {match: main/look/capture, outputs: {frame: {time: nan s, sequence: 1.5}}}
  - {match: main/look/track_height, outputs: {height: none}, then: never}
expect: {result: yes}
"""
    )
    wanted = [
        (5, "unit-missing"),
        (6, "mock-unmatched"),
        (7, "type-mismatch"),
        (7, "type-mismatch"),
        (8, "type-mismatch"),
        (8, "option-unknown"),
        (9, "option-unknown"),
    ]
    assert [(d.line, d.code) for d in check(path)] == wanted
    with pytest.raises(MocksError) as refused:
        run(tmp_path / "tree.yaml", mocks=path)
    assert [(d.line, d.code) for d in refused.value.diagnostics] == wanted


def test_a_shipped_tree_is_checked_by_its_name_as_it_is_run_by_it():
    assert check("palpate_stiffness") == []
    assert {finding.code for finding in check("palpate_stiffness", cell="lab_ur5")} == {"cell-limit"}
    [unknown] = check("palpate_stifness")
    assert (unknown.code, "'palpate_stiffness'" in unknown.hint) == ("file-missing", True)


@pytest.mark.parametrize("form", ["./{}", "x/../{}", "{}"])
@pytest.mark.parametrize(
    "text",
    [
        "format: stretch-tree/1\ntrees: {main: {sequence: [pres: {depth: 1 mm}]}}\n",
        "format: stretch-scene/1\nobject: {}\n",
        "format: stretch-cell/1\ndevices: {arm: {}}\n",
        "format: stretch-mocks/1\ntree: palpate_stiffness\nmocks: [{match: nowhere}]\n",
        "format: stretch-sweep/1\ntree: nowhere\n",
        "doc: none\n",
        "a: [",
    ],
)
def test_a_finding_has_the_name_that_its_file_was_given(text, form, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x").mkdir()
    (tmp_path / "a.yaml").write_text(text)
    given = form.format("a.yaml")
    assert {finding.file for finding in check(given)} == {given}


def test_a_finding_of_a_shipped_tree_has_the_name_that_was_given():
    found = {finding.file for finding in check("form_cookie", cell="lab_ur5")}
    assert "form_cookie" in found
    assert "form_cookie.yaml" not in found


OWN = """\
from stretch_bt.tree.ports import Behavior, Status
from stretch_bt.tree.registry import node


@node
class BreaksWhenMade(Behavior):
    '''Never ticks.'''

    def __init__(self, path=""):
        super().__init__(path)
        raise ValueError("no")

    def update(self):
        return Status.SUCCESS
"""


def test_a_node_that_cannot_be_made_is_a_finding_beside_a_cell_and_mocks_too(tmp_path, own_nodes):
    (tmp_path / "breaks_when_made.py").write_text(OWN)
    tree, mocks = tmp_path / "tree.yaml", tmp_path / "tree.mocks.yaml"
    tree.write_text(
        "format: stretch-tree/1\nimports: {own: breaks_when_made}\ntrees: {main: {sequence: [breaks_when_made]}}\n"
    )
    mocks.write_text("format: stretch-mocks/1\ntree: tree.yaml\nmocks: []\n")
    assert [finding.code for finding in check(tree)] == ["import"]
    assert [finding.code for finding in check(tree, cell="simulated")] == ["import"]
    [found] = check(mocks)
    assert found.code == "tree-wrong"
    assert "breaks_when_made" in found.message


def test_files_are_checked_in_the_order_given_and_warnings_are_no_errors(tmp_path):
    good, spare, wrong = (tmp_path / f"{name}.yaml" for name in ("good", "spare", "wrong"))
    good.write_text("format: stretch-tree/1\ntrees: {main: {sequence: [wait: {duration: 1 s}]}}\n")
    spare.write_text(
        "format: stretch-tree/1\ndevices: {arm: Arm}\ntrees: {main: {sequence: [wait: {duration: 1 s}]}}\n"
    )
    wrong.write_text("")
    found = check([wrong, good, spare])
    assert [(Path(d.file).stem, d.severity, d.code) for d in found] == [
        ("wrong", "error", "file-empty"),
        ("spare", "warning", "device-unused"),
    ]


def test_an_entry_that_a_list_has_not_is_told_once(tmp_path):
    path = tmp_path / "tree.yaml"
    head = "format: stretch-tree/1\nparams: {xs: {type: 'list[int]', default: [1, 2]}}\nkeys: {a: int}\n"
    path.write_text(head + "trees: {main: {sequence: [set: {a: xs.5}, set: {a: xs.5 + 1}]}}\n")
    assert [d.message for d in check([path])] == [
        "'xs.5' has no value: the list holds 2",
        "'xs.5 + 1' has no value: xs.5: the list holds 2",
    ]


@pytest.mark.parametrize("format_", ["tree", "scene", "sweep"])
def test_a_slip_in_the_word_format_is_told_as_one_whatever_the_file_is(format_: str, tmp_path: Path) -> None:
    """A sweep was to begin with the format of a tree."""
    path = tmp_path / "a.yaml"
    path.write_text(f"doc: x\nformt: stretch-{format_}/1\n")
    (found,) = check(path)
    assert (found.line, found.message, found.hint) == (2, "unknown key 'formt'", "did you mean 'format'?")


@pytest.mark.parametrize("text", ["doc: x\ntrees: {main: {check: 1 > 0}}\n", "doc: x\nformat: stretch-tree/1\n"])
def test_a_format_may_stand_anywhere_and_is_said_to_be_missing_where_it_is(text: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(text)
    found = check(path)[0]
    wanted = (
        ("trees-missing", "the file has no trees")
        if "format" in text
        else ("format-missing", "the file has no 'format'")
    )
    assert (found.code, found.message) == wanted
