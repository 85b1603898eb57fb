"""What a tree asks of a cell is held against the cell's devices and limits before anything moves."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import stretch_bt
from stretch_bt import check
from stretch_bt.cli.app import app
from stretch_bt.hardware.limits import Limits
from stretch_bt.quantity_text import format_quantity
from stretch_bt.tree.ports import Role
from stretch_bt.tree.registry import load_all
from stretch_bt.tree.types import Family

TREES = Path(stretch_bt.__file__).parent / "trees"
#: so tight that every port with a limit can be past it
CELL = """\
format: stretch-cell/1
devices:
  arm: {type: Arm, use: simulated}
  gripper: {type: Gripper, use: simulated, max_opening: MOST}
  camera: {type: DepthCamera, use: simulated}
limits:
  x: {min: -20 mm, max: 20 mm}
  y: {min: -20 mm, max: 20 mm}
  height: {min: 30 mm, max: 60 mm}
  speed: 2 mm/s
  contact: {below: 40 mm, speed: 1.5 mm/s}
  gripper_speed: 2 mm/s
  depth: 2 mm
  stretch: {min: 0 mm, max: 20 mm}
  force: 0.2 N
"""
TREE = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
params: {deep: {type: Length, default: 1 mm, max: 10 mm}, fast: {type: Speed, default: 1 mm/s, max: 2 mm/s}}
keys: {depth: Length, touch: Touch}
trees:
  main:
BODY
"""
SINK = """\

  sink:
    in: {depth: Length, touch: Touch}
    sequence: [press: {depth: $depth, speed: 1 mm/s, max_force: 0.1 N}]"""
MARKED = re.compile("«(.*?)»", re.DOTALL)
QUIET = "speed: 1 mm/s, max_force: 0.1 N"


def limited():
    """Every port of a shipped node that has a limit and whose node can be given literals alone."""
    for info in load_all().values():
        needed = [p for p in info.ports.values() if p.required and p.name != "touch"]
        if info.cls.__module__.startswith("stretch_bt.") and all(
            info.types[p.name].family is Family.QUANTITY for p in needed
        ):
            yield from ((info, p) for p in info.of(Role.INPUT) if p.limit not in (None, "lowered_force"))


@pytest.fixture
def held(tmp_path):
    """Hold a tree, written with marks, against a cell; return the findings of limits and the marked place."""

    def hold(body, most="140 mm"):
        text = TREE.replace("BODY", body)
        path, cell = tmp_path / "tree.yaml", tmp_path / "cell.yaml"
        path.write_text(MARKED.sub(r"\1", text))
        cell.write_text(CELL.replace("MOST", most))
        mark = MARKED.search(text)
        place = mark and (text.count("\n", 0, mark.start()) + 1, mark.start() - text.rfind("\n", 0, mark.start()))
        return [d for d in check(path, cell=cell) if d.code == "cell-limit"], place

    return hold


def test_every_limit_of_a_port_is_one_of_a_cell_and_nodes_that_move_have_them():
    ports = [(info.name, p) for info in load_all().values() for p in info.of(Role.INPUT)]
    for _, p in ports:
        if p.limit is not None:
            low, high = Limits().span(p.limit)
            assert low < high
    moving = {"speed", "max_force", "depth", "max_depth", "stretch", "max_stretch", "x", "y", "max_travel"}
    nodes = {"descend", "press", "roll", "retract", "set_stretch", "move_over", "list_presses"}
    without = {(name, p.name) for name, p in ports if name in nodes and p.name in moving and p.limit is None}
    assert without == {("descend", "max_travel")}  # which ends where the cell does


@pytest.mark.parametrize(("info", "declared"), [pytest.param(i, p, id=f"{i.name}-{p.name}") for i, p in limited()])
def test_a_constant_past_a_limit_is_found_at_its_place_and_one_at_the_limit_is_not(held, info, declared):
    kind = info.types[declared.name].kind
    limits = {
        "x": 0.02,
        "y": 0.02,
        "speed": 0.002,
        "contact_speed": 0.0015,
        "gripper_speed": 0.002,
        "depth": 0.002,
        "stretch": 0.02,
        "force": 0.2,
        "held_force": 0.2,
    }
    most = {**limits, "travel": 0.03, "radius": 0.02}[declared.limit]
    others = {
        p.name: format_quantity(p.min or 0.0, info.types[p.name].kind)
        for p in info.of(Role.INPUT)
        if p.required and p.name != "touch"
    }
    for value, past in ((most, False), (1.1 * most, True)):
        given = {**others, declared.name: f"«{format_quantity(value, kind)}»"}
        body = (
            f"    sequence: [set: {{touch: none}}, {info.name}: {{{', '.join(f'{k}: {v}' for k, v in given.items())}}}]"
        )
        found, place = held(body)
        mine = [d for d in found if f": {declared.name} is" in d.message]
        assert [(d.line, d.column, d.severity) for d in mine] == [(*place, "error")] * past
        assert all(f"main/{info.name}: {declared.name} is {format_quantity(value, kind)}" in d.message for d in mine)


KNOWN = "    sequence: [set: {touch: none}, "
FOUND = {
    "a default of a node": (KNOWN + "«press»: {depth: 1 mm, speed: 1 mm/s}]", "error", "main/press: max_force is 15 N"),
    "a param": (KNOWN + f"press: {{depth: «5 * $deep», {QUIET}}}]", "error", "main/press: depth is 5 mm"),
    "the range of a param": (
        KNOWN + f"press: {{depth: $deep, {QUIET}}}]",
        "warning",
        "deep = 10 mm, main/press: depth is 10 mm",
    ),
    "a call": (
        KNOWN + "sink: {depth: 1 mm}, {name: again, sink: {depth: «3 mm»}}]" + SINK,
        "error",
        "main/again/press: depth is 3 mm",
    ),
    "a call of a shipped tree": (
        KNOWN + "approach: {speed: «3 mm/s», feel_speed: 1 mm/s, max_force: 0.1 N}]",
        "error",
        "main/approach/descend: speed is 3 mm/s",
    ),
    "a call of a call": (
        KNOWN
        + "deeper: {to: «3 mm»}]\n  deeper:\n    in: {to: Length, touch: Touch}\n    sequence: [sink: {depth: $to}]"
        + SINK,
        "error",
        "main/deeper/sink/press: depth is 3 mm",
    ),
    "a key": (
        KNOWN + f"set: {{depth: task.time * 1 mm/s}}, press: {{depth: «$depth», {QUIET}}}]",
        "warning",
        "main/press: depth is known in the run alone and takes up to 30 mm; cell.yaml allows at most 2 mm",
    ),
}


@pytest.mark.parametrize("case", FOUND)
def test_what_a_tree_can_reach_is_found_with_its_path(held, case):
    body, severity, said = FOUND[case]
    found, place = held(body)
    [one] = [d for d in found if "run alone" not in d.message or case == "a key"]
    assert (one.severity, said in one.message) == (severity, True), one
    if place is not None:
        assert (one.line, one.column) == place
    elif case == "the range of a param":
        assert (one.line, one.column) == (3, 10)


@pytest.mark.parametrize(
    "cell", ["lab_ur5", *(pytest.param(cell, marks=pytest.mark.slow) for cell in ("lab_ur5e", "simulated"))]
)
@pytest.mark.parametrize("tree", sorted(TREES.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_trees_ask_for_nothing_that_shipped_cells_do_not_allow(tree, cell):
    found = check(tree, cell=cell)
    assert [d for d in found if d.code == "cell-force" or (d.code == "cell-limit" and d.severity == "error")] == []


def test_a_stretch_past_what_the_fingers_open_is_found(held):
    body = "    set_stretch: {stretch: «15 mm», speed: 1 mm/s}"
    assert held(body)[0] == []
    [found], place = held(body, most="60 mm")
    assert (found.line, found.column) == place
    assert "allows 0 mm to 5 mm" in found.message


@pytest.mark.parametrize(
    ("tick", "node", "cell", "told"),
    [
        ("1 s", "retract: {clearance: 1 mm}", "lab_ur5", True),
        ("0.9 s", "retract: {clearance: 1 mm}", "lab_ur5", False),
        ("1 s", "capture: {frame: $frame}", "lab_ur5", False),
        ("1 s", "retract: {clearance: 1 mm}", "simulated", False),
    ],
)
def test_ticks_that_are_too_far_apart_for_a_motion_are_found(tmp_path, tick, node, cell, told):
    (tmp_path / "tree.yaml").write_text(
        f"format: stretch-tree/1\ntick: {tick}\ndevices: {{arm: Arm, camera: DepthCamera}}\nkeys: {{frame: DepthFrame}}\n"
        f"trees: {{main: {{{node}}}}}\n"
    )
    found = [d for d in check(tmp_path / "tree.yaml", cell=cell) if "no tick looks" in d.message]
    assert [(d.line, d.column, d.severity, d.code) for d in found] == [(2, 7, "warning", "cell-limit")] * told


def test_the_command_tells_it_and_a_device_that_is_missing(tmp_path):
    (tmp_path / "tree.yaml").write_text(
        TREE.replace("BODY", f"    sequence: [set: {{touch: none}}, press: {{depth: 3 mm, {QUIET}}}]")
    )
    (tmp_path / "cell.yaml").write_text(CELL.replace("MOST", "140 mm"))
    done = CliRunner().invoke(
        app, ["check", str(tmp_path / "tree.yaml"), "--cell", str(tmp_path / "cell.yaml"), "--json"]
    )
    assert done.exit_code == 2
    errors = [d for d in json.loads(done.stdout) if d["severity"] == "error"]
    assert [(d["line"], d["column"], d["code"]) for d in errors] == [
        (7, len("    sequence: [set: {touch: none}, press: {depth: ") + 1, "cell-limit")
    ]
    (tmp_path / "tree.yaml").write_text(
        TREE.replace("BODY", "    sequence: [set: {touch: none}, press: {depth: 3 mm, max_force: 5 N}]")
    )
    found = check(tmp_path / "tree.yaml", cell="lab_ur5")
    assert not [d for d in found if d.code == "cell-limit" and d.severity == "error"]
    (tmp_path / "tree.yaml").write_text(
        TREE.replace("BODY", "    sequence: [capture: {frame: $f}]\n    keys: {f: DepthFrame}")
    )
    blind = tmp_path / "blind.yaml"
    blind.write_text("".join(line for line in CELL.replace("MOST", "140 mm").splitlines(True) if "camera" not in line))
    found = check(tmp_path / "tree.yaml", cell=str(blind))
    assert [d.code for d in found if d.severity == "error"] == ["device-missing"]
    assert [d.code for d in check(tmp_path / "tree.yaml", cell="no_such_cell")][-1] == "cell-unknown"
