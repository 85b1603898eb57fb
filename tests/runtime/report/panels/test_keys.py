"""What panels read of a record is what the shipped trees write into it."""

from dataclasses import fields
from pathlib import Path

import pytest

from stretch_bt.behaviors.records import Felt, Reading
from stretch_bt.perception import Solid, Sphere
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.report.panels import PANELS, cookie, keys, looks
from stretch_bt.runtime.report.panels.keys import Key
from stretch_bt.tree.build import build
from stretch_bt.tree.program import load_program

#: what the keys hold of which fields are read
RECORDS = {"main/sphere": Sphere, "main/felt": Felt, "main/solid": Solid}
MODULES = (*PANELS, looks)
GIVEN = [v for module in MODULES for v in vars(module).values()]
FOUND = {key for v in GIVEN for key in (v if isinstance(v, tuple) else (v,)) if isinstance(key, Key)}
READ = sorted(FOUND, key=lambda key: key.name)


@pytest.fixture(scope="module")
def built():
    trees = {tree for key in READ for tree in key.trees} | set(cookie.TREES)
    return {tree: build(load_program(tree), RunContext()) for tree in trees}


@pytest.mark.parametrize("key", READ, ids=lambda key: key.name)
def test_every_key_that_a_panel_reads_is_one_of_its_trees(built, key):
    assert key.trees
    for tree in key.trees:
        assert any(key.names(cell.name) for cell in built[tree].cells), tree


@pytest.mark.parametrize("key", [key for key in READ if key.fields], ids=lambda key: key.name)
def test_every_field_that_a_panel_reads_is_one_that_the_record_holds(key):
    assert set(key.fields) <= {field.name for field in fields(RECORDS[key.name])}


def test_so_are_the_fields_of_the_latest_reading():
    assert set(looks.LAST) <= {field.name for field in fields(Reading)}


@pytest.mark.parametrize("tree", cookie.TREES)
def test_every_output_that_a_panel_reads_is_one_of_its_trees(built, tree):
    assert set(cookie.CIRCULARITIES) <= built[tree].outputs.keys()


def test_no_panel_reads_a_key_in_another_way():
    folder = Path(keys.__file__).parent
    assert [file.name for file in folder.glob("*.py") if '"key"' in file.read_text("utf-8")] == ["keys.py"]
