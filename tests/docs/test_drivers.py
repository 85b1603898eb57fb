"""The drivers on the page are the ones that `new device` writes, short, and hold the contract of devices."""

import ast
import io
import re
import subprocess
import sys
import time
import tokenize
from pathlib import Path

import pytest

import stretch_bt
from stretch_bt.cli.command_new import DEVICES, command
from stretch_bt.runtime.check import check

PAGE = Path(__file__).parents[2] / "docs" / "drivers.md"
BLOCKS = re.findall(r"<!-- new: (\w+) (\w+) -->\n```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
NO_CODE = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
LONGEST = 40


def lines_of_code(text):
    """Return how many lines have code, docstrings and comments not counted."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    found = {
        token.start[0] for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type not in NO_CODE
    }
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, documented) and ast.get_docstring(node) is not None:
            found -= set(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    return len(found)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with what `new device` writes for every kind."""
    where = tmp_path_factory.mktemp("drivers")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(where)
        for name, kind, _ in BLOCKS:
            command("device", name, kind)
    (where / "pytest.ini").write_text("[pytest]\n")
    return where


def test_the_page_has_every_kind():
    assert {kind for _, kind, _ in BLOCKS} == set(DEVICES)


@pytest.mark.parametrize(("name", "kind", "text"), BLOCKS, ids=[name for name, _, _ in BLOCKS])
def test_the_driver_of_the_page_is_the_one_that_is_written_and_is_short(folder, name, kind, text):
    assert (folder / f"{name}.py").read_text("utf-8") == text, (
        f"take the page's driver from `new device {name} --kind {kind}`"
    )
    assert lines_of_code(text) <= LONGEST
    assert check(folder / f"{name}.yaml") == []


def test_two_devices_of_one_driver_are_two(folder):
    entry = "{type: Gripper, use: my_gripper}"
    path = folder / "two.yaml"
    path.write_text(
        f"format: stretch-cell/1\nimports: {{own: my_gripper}}\ndevices: {{left: {entry}, right: {entry}}}\n", "utf-8"
    )
    with stretch_bt.open_cell(path) as cell:
        before = cell.right.opening(1.0).value
        cell.left.move(before + 0.005, speed=0.1, owner="test")
        end = time.monotonic() + 20
        while cell.left.opening(1.0).value < before + 0.005:
            assert time.monotonic() < end
        assert cell.right.opening(1.0).value == before


def test_what_is_written_holds_the_contract(folder):
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
