"""Whatever is killed, the rows in the end are the rows of a sweep that nothing disturbed."""

import random
from argparse import Namespace

import pytest
from sweep_engines import DISTURBED, disturbed, ended_by_an_item, of_tree, rows_of, swept

ITEMS = 12
#: takes long enough that a moment lies within an item
TREE = """\
format: stretch-tree/1
trees: {main: {out: {reached: int}, sequence: [{wait: {duration: 300 s}}, {set: {reached: 1}}]}}
"""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    tree = tmp_path_factory.mktemp("tree") / "wait.yaml"
    tree.write_text(TREE)
    return of_tree(tmp_path_factory.mktemp("sweep"), tree, ITEMS)


@pytest.fixture(scope="module")
def wanted(file, tmp_path_factory):
    out = tmp_path_factory.mktemp("serial") / "out"
    assert swept(file, out, "serial", 1)[0] == 0
    return rows_of(out)


@pytest.mark.parametrize("what", DISTURBED)
@pytest.mark.parametrize("engine", ["local", "dask"])
def test_rows_are_those_of_an_undisturbed_sweep(file, wanted, tmp_path, engine, what):
    assert disturbed(file, tmp_path / "out", engine, 2, what, ITEMS, random.Random(1)) < ITEMS
    assert rows_of(tmp_path / "out") == wanted


@pytest.mark.parametrize("engine", ["local", "dask"])
def test_an_item_that_ends_its_worker_is_one_row_and_all_others_are_there(tmp_path, engine):
    ((_, good, told),) = ended_by_an_item(Namespace(items=8, engines=[engine], workers=2), tmp_path)
    assert good, told
