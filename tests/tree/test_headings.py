"""What the headings of a tree file declare, with the parameters that a run gives, in imported files too."""

import sys
from pathlib import Path
from typing import Any

import pytest

from stretch_bt.errors import TreeError
from stretch_bt.tree import registry
from stretch_bt.tree.imports import MAX_FILES
from stretch_bt.tree.program import load_program
from stretch_bt.tree.shared import shipped

TREE = """
format: stretch-tree/1
imports: {lib: lib.yaml}
params:
  depth: {type: Length, default: 3 mm, min: 1 mm, max: 5 mm}
  steps: {type: "list[Length]", default: [1 mm, 2 mm], max: 9 mm}
  often: {type: int, default: 3, min: 1}
  look: {type: bool, default: true}
  share: {type: float, default: 5 %}
  model: {type: str, default: paper}
trees: {main: {sequence: [lib.pause: {}, check: depth > 0 mm]}}
"""
LIB = """
format: stretch-tree/1
params: {rest: {type: Time, default: 1 s, max: 10 s}}
trees: {pause: {in: {n: {type: int, default: 1}}, sequence: [wait: {duration: $rest}]}}
"""


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    (tmp_path / "lib.yaml").write_text(LIB)
    (tmp_path / "tree.yaml").write_text(TREE)
    return tmp_path / "tree.yaml"


#: name, text of the command line, value
GIVEN = [
    ("depth", "4 mm", 0.004),
    ("depth", "4mm", 0.004),
    ("depth", 0.004, 0.004),
    ("steps", "[3 mm, 4mm]", [0.003, 0.004]),
    ("steps", "[]", []),
    ("steps", [0.003], [0.003]),
    ("often", "7", 7),
    ("often", 7, 7),
    ("look", "false", False),
    ("look", False, False),
    ("share", "0.25", 0.25),
    ("share", "25 %", 0.25),
    ("model", "my model: [1", "my model: [1"),
]


@pytest.mark.parametrize(("name", "text", "value"), GIVEN)
def test_a_parameter_is_given_at_load(tree: Path, name: str, text: Any, value: Any) -> None:
    program = load_program(tree, {name: text}).require()
    assert program.document.params[name].value == pytest.approx(value)


def test_a_parameter_of_an_imported_file_is_given_under_its_prefix(tree: Path) -> None:
    program = load_program(tree, {"lib.rest": "2 s"}).require()
    assert program.document.imports["lib"].params["rest"].value == 2.0
    assert load_program(tree).document.imports["lib"].params["rest"].value == 1.0


#: name, text, code, column in `name=text`, part of the hint
WRONG = [
    ("dept", "4 mm", "param-unknown", 1, "did you mean 'depth'?"),
    ("lib.rset", "4 s", "param-unknown", 1, "did you mean 'lib.rest'?"),
    ("rest", "4 s", "param-unknown", 1, "did you mean 'lib.rest'?"),
    ("lib.frame", "4", "param-unknown", 1, "known here: lib.rest"),
    ("depth", "4", "unit-missing", 7, "write '4 mm'"),
    ("depth", "4 N", "unit-mismatch", 7, "mm"),
    ("depth", "4 MM", "unit-unknown", 7, "write '4 mm'"),
    ("depth", "6 mm", "out-of-bounds", 7, "'5 mm'"),
    ("depth", "", "value-missing", 7, "10 mm"),
    ("depth", "[1 mm]", "type-mismatch", 7, "10 mm"),
    ("depth", "{a: 1 mm}", "type-mismatch", 7, "10 mm"),
    ("depth", "nan mm", "type-mismatch", 7, "10 mm"),
    ("depth", "1e999 mm", "type-mismatch", 7, "10 mm"),
    ("depth", 6e-3, "out-of-bounds", 7, "'5 mm'"),
    ("steps", "1 mm", "type-mismatch", 7, "[10 mm, ...]"),
    ("steps", "[1 mm", "type-mismatch", 7, "[10 mm]"),
    ("steps", "[1 mm, 90 mm]", "out-of-bounds", 7, "'9 mm'"),
    ("often", "0", "out-of-bounds", 7, "'1'"),
    ("often", "2.5", "type-mismatch", 7, "whole number"),
    ("look", "yes", "type-mismatch", 6, "write 'true'"),
    ("lib.rest", "11 s", "out-of-bounds", 10, "'10 s'"),
    ("lib.rest", "11", "unit-missing", 10, "write '11 s'"),
]


@pytest.mark.parametrize(("name", "text", "code", "column", "hint"), WRONG)
def test_a_wrong_parameter_is_refused_at_its_place(
    tree: Path, name: str, text: Any, code: str, column: int, hint: str
) -> None:
    [found] = load_program(tree, {name: text}).errors
    assert (found.file, found.line, found.column, found.code) == ("--set", 1, column, code)
    assert hint in found.hint


@pytest.mark.parametrize("rest", ["default: 2 mm, ", ""])
@pytest.mark.parametrize("text", ["80 mm", "4 N"])
def test_what_a_param_refuses_is_not_refused_again_where_it_is_used(tmp_path: Path, rest: str, text: str) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(
        f"format: stretch-tree/1\ndevices: {{arm: Arm}}\nparams: {{deep: {{{rest}min: 1 mm, max: 5 mm, type: Length}}}}\n"
        "trees: {main: {lower: {by: $deep}}}\n"
    )
    [found] = load_program(path, {"deep": text}).errors
    assert (found.file, found.line) == ("--set", 1)


def test_positions_survive_what_the_command_line_gives(tree: Path) -> None:
    tree.write_text(TREE.replace("> 0 mm", "> 0 N"))
    [given, other] = load_program(tree, {"depth": "6 mm"}).errors
    assert (given.file, given.line) == ("--set", 1)
    assert (Path(other.file).name, other.line, other.code) == ("tree.yaml", 11, "unit-mismatch")


def test_an_import_is_found_beside_the_tree_first_and_then_among_the_shipped_ones(tmp_path: Path) -> None:
    name = next(p.name for p in sorted(shipped("").glob("*.yaml")))
    text = f"format: stretch-tree/1\nimports: {{other: {name}}}\ntrees: {{main: {{sequence: [wait: {{duration: 1 s}}]}}}}\n"
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    assert load_program(path).document.imports["other"].path == shipped(name)
    (tmp_path / name).write_text(LIB)
    assert load_program(path).document.imports["other"].path == tmp_path / name


def test_imports_reach_through_imports_and_folders(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "inner.yaml").write_text(LIB)
    outer = "format: stretch-tree/1\nimports: {inner: inner.yaml}\ntrees: {twice: {out: {n: int}, sequence: [inner.pause, set: {n: 2}]}}\n"
    (tmp_path / "lib" / "outer.yaml").write_text(outer)
    tree = tmp_path / "tree.yaml"
    tree.write_text(
        "format: stretch-tree/1\nimports: {a: lib/outer.yaml}\ntrees: {main: {sequence: [a.twice, a.inner.pause: {}]}}\n"
    )
    program = load_program(tree, {"a.inner.rest": "3 s"}).require()
    assert program.document.imports["a"].imports["inner"].params["rest"].value == 3.0
    assert set(program.document.files) == {
        str(tree),
        str(tmp_path / "lib/outer.yaml"),
        str(tmp_path / "lib/inner.yaml"),
    }


def test_imports_that_multiply_are_cut_short(tmp_path: Path) -> None:
    for i in range(30):
        text = f"format: stretch-tree/1\nimports: {{p: t{i + 1}.yaml, q: t{i + 1}.yaml}}\n"
        (tmp_path / f"t{i}.yaml").write_text(text + "trees: {main: {sequence: [wait: {duration: 1 s}]}}\n")
    (tmp_path / "t30.yaml").write_text(LIB)
    found = load_program(tmp_path / "t0.yaml").errors
    assert any(f"more than {MAX_FILES} files" in d.message for d in found)


NODES = '''
from stretch_bt import Behavior, In, Out, Status, node
from stretch_bt.units import Length

@node
class HalveLength(Behavior):
    """Half of a length."""

    whole: In[Length]
    half: Out[Length]

    def update(self) -> Status:
        self.half = self.whole / 2
        return Status.SUCCESS
'''


def test_a_module_beside_the_tree_brings_its_nodes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    registry.load_all()
    monkeypatch.setattr(registry, "_nodes", registry.load_all())
    (tmp_path / "halving_nodes.py").write_text(NODES)
    tree = tmp_path / "tree.yaml"
    body = "sequence: [%s: {whole: 4 mm, half: $h}, check: h > 0 mm]"
    text = f"format: stretch-tree/1\nimports: {{mine: halving_nodes}}\ntrees: {{main: {{{body}}}}}\n"
    before = list(sys.path)
    try:
        for name in ("halve_length", "mine.halve_length"):
            tree.write_text(text % name)
            assert load_program(tree).diagnostics == []
        tree.write_text(text.replace("$h}", "$h, holf: $h}") % "halve_length")
        [found] = load_program(tree).errors
        assert found.code == "port-unknown"
    finally:
        sys.modules.pop("halving_nodes", None)
    assert sys.path == before


@pytest.mark.parametrize("code", ["raise SystemExit(3)", "1 / 0", "import no_such_module", "def"])
def test_a_module_that_breaks_is_an_error_at_its_import(code: str, tmp_path: Path) -> None:
    (tmp_path / "broken_nodes.py").write_text(code)
    tree = tmp_path / "tree.yaml"
    tree.write_text("format: stretch-tree/1\nimports: {mine: broken_nodes}\ntrees: {main: {sequence: [mine.thing]}}\n")
    [found] = load_program(tree).errors
    assert (found.code, found.line, found.column) == ("import", 2, 17)


def test_a_file_of_trees_with_borders_is_a_library(tmp_path: Path) -> None:
    path = tmp_path / "lib.yaml"
    path.write_text(LIB)
    assert load_program(path).diagnostics == []
    path.write_text(LIB.replace("in: {n: {type: int, default: 1}}, ", ""))
    [found] = load_program(path).diagnostics
    assert (found.severity, found.code) == ("warning", "main-missing")


def test_a_tree_that_does_not_exist_is_named() -> None:
    with pytest.raises(TreeError, match="did you mean 'palpate_stiffness'"):
        load_program("palpate_stifness")
