"""Sweep files: what they may say, and each mistake at its place."""

import jsonschema
import pytest
import yaml

from stretch_bt.errors import SweepError
from stretch_bt.simulation.scene.asked import read_asked
from stretch_bt.tree.schema import schema
from stretch_bt.tree.sweep_file import FORMAT, read_sweep

WHOLE = """\
format: stretch-sweep/1
doc: how deep
tree: palpate_stiffness
scene: [water_balloon, seeds_balloon]
cell: simulated
seeds: {from: 10, count: 5}
set: {wanted_deflection: [1 mm, 2 mm], touches: 3, diameters: [[20 mm, 30 mm]]}
tolerance: {stiffness: 2 %, height: 0.3 mm}
limit: 10 min
record: events
"""
#: a line that replaces the line with the same key -> where it is wrong, and a part of the message
WRONG = {
    "format: stretch-sweep/2": ("1:9", "stretch-sweep/1"),
    "tree: []": ("3:7", "at least one"),
    "tree: [palpate_active, palpate_active]": ("3:24", "twice"),
    "tree: [a.yaml, ./a.yaml]": ("3:16", "tree has 'a.yaml' and './a.yaml', which are the same"),
    "scene: [b.yaml, c/../b.yaml]": ("4:17", "which are the same"),
    "tree: {name: a}": ("3:7", "text"),
    "tree:": ("3:6", "tree is empty; write 'tree: palpate_stiffness'"),
    "scene:": ("4:7", "scene is empty; write 'scene: water_balloon', or leave it out"),
    "cell:": ("5:6", "cell is empty; write 'cell: simulated', or leave it out"),
    "scene: ['']": ("4:9", "is empty"),
    'cell: ""': ("5:7", "cell is empty"),
    "limit:": ("9:7", "limit is empty; write 'limit: 1 s', or leave it out"),
    "scene: [water_balloon, 3]": ("4:24", "text"),
    "cell: [simulated]": ("5:7", "text"),
    "seeds: 0": ("6:8", "seeds"),
    "seeds: -3": ("6:8", "seeds: -3 is out of bounds; write at least 1"),
    "seeds: six": ("6:8", "write 6 for 0 to 5"),
    "seeds: true": ("6:8", "write 6 for 0 to 5"),
    "seeds: {from: -1, count: 2}": ("6:15", "from"),
    "seeds: {from: 1}": ("6:8", "count"),
    "seeds: {from: 1, number: 2}": ("6:8", "count"),
    "seeds: {count: 100000000}": ("1:1", "400,000,000 items"),
    "set: [a]": ("7:6", "mapping"),
    "set: {touches: []}": ("7:16", "at least one"),
    "set: {touches: [3, 3]}": ("7:20", "twice"),
    "set: {wanted_deflection: [1 mm, 2 mm, 0.1 cm]}": ("7:39", "'1 mm' and '0.1 cm', which are the same"),
    "tolerance: {stiffnes: 2 %}": ("8:13", "stiffness"),
    "tolerance: {height: 2 %}": ("8:21", "mm"),
    "tolerance: {stiffness: 2 mm}": ("8:24", "5 %"),
    "tolerance: {}": ("8:12", "at least one"),
    "limit: 10": ("9:8", "10 s"),
    "limit: 0 s": ("9:8", "at least"),
    "record: all": ("10:9", "record takes full, events or none, not 'all'; write full, events or none"),
    "record: ful": ("10:9", "did you mean 'full'?"),
    "scenes: water_balloon": ("4:1", "scene"),
}


def written(tmp_path, text):
    path = tmp_path / "sweep.yaml"
    path.write_text(text)
    return path


def load_sweep(path):
    found, wrong = read_sweep(path)
    if wrong:
        raise SweepError(wrong)
    return found


def with_line(line):
    key = {"scenes": "scene"}.get(line.partition(":")[0], line.partition(":")[0])
    return "".join(f"{line}\n" if old.startswith(f"{key}:") else f"{old}\n" for old in WHOLE.splitlines())


def test_a_whole_file_is_read(tmp_path):
    found = load_sweep(written(tmp_path, WHOLE))
    assert [tree.text for tree in found.trees] == ["palpate_stiffness"]
    assert [scene.text for scene in found.scenes] == ["water_balloon", "seeds_balloon"]
    assert (found.cell.text, found.seeds, found.limit, found.record) == ("simulated", range(10, 15), 600.0, "events")
    assert found.tolerance == {"stiffness": 0.02, "height": 0.0003}
    assert {name: len(values) for name, values in found.choices.items()} == {
        "wanted_deflection": 2,
        "touches": 1,
        "diameters": 1,
    }
    assert len(found) == 2 * 5 * 2


def test_only_a_tree_must_be_named(tmp_path):
    found = load_sweep(written(tmp_path, f"format: {FORMAT}\ntree: palpate_stiffness\n"))
    assert (found.scenes, found.cell, found.seeds, found.limit, found.record) == ((), None, range(1), None, "none")
    assert len(found) == 1
    with pytest.raises(SweepError, match="tree is missing"):
        load_sweep(written(tmp_path, f"format: {FORMAT}\n"))


@pytest.mark.parametrize("given", ["{stiffness: 2 %}", "{stiffness: 0.02}", "{height: 0.3 mm, roundness: 0.1}"])
def test_a_run_takes_each_tolerance_that_a_sweep_may_have(tmp_path, given):
    """A part without its % was right here, and each item refused it."""
    found = load_sweep(written(tmp_path, with_line(f"tolerance: {given}")))
    assert read_asked(found.tolerance).named() == pytest.approx(found.tolerance)


@pytest.mark.parametrize("line", WRONG)
def test_a_mistake_is_told_at_its_place(tmp_path, line):
    place, said = WRONG[line]
    path = written(tmp_path, with_line(line))
    with pytest.raises(SweepError) as refused:
        load_sweep(path)
    first = refused.value.diagnostics[0]
    assert (f"{first.line}:{first.column}", first.severity) == (place, "error")
    assert said in str(first)


def test_the_schema_takes_what_is_right_and_refuses_most_that_is_wrong():
    checker = jsonschema.Draft202012Validator(schema("sweep"))
    assert list(checker.iter_errors(yaml.safe_load(WHOLE))) == []
    taken = {line for line in WRONG if not list(checker.iter_errors(yaml.safe_load(with_line(line))))}
    # what no schema says: that two values are the same, how many items there are, which unit a number has, and that
    # nothing is not `null`
    assert taken == {
        "scene:",
        "cell:",
        "limit:",
        "tree: [palpate_active, palpate_active]",
        "tree: [a.yaml, ./a.yaml]",
        "scene: [b.yaml, c/../b.yaml]",
        "seeds: {count: 100000000}",
        "set: {touches: [3, 3]}",
        "set: {wanted_deflection: [1 mm, 2 mm, 0.1 cm]}",
        "tolerance: {height: 2 %}",
        "tolerance: {stiffness: 2 mm}",
        "tolerance: {}",
        "limit: 0 s",
    }
