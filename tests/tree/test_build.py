"""From a checked task to nodes: paths that stay, fresh nodes at every place, cells of their own."""

from typing import Any

import pytest

from stretch_bt.clock import VirtualClock
from stretch_bt.errors import NodeError
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.runner import Runner
from stretch_bt.tree.build import build
from stretch_bt.tree.paths import Paths
from stretch_bt.tree.program import load_program

#: body -> every path, in the order of building from the leaves up
PATHS = {
    "sequence: [step, {name: b, step: {}}]": ["main/sequence", "main/step", "main/b"],
    "sequence: [step, step]": ["main/sequence", "main/step[0]", "main/step[1]"],
    "sequence: [step, sequence: [step]]": ["main/sequence[0]", "main/step[0]", "main/sequence[1]", "main/step[1]"],
    "sequence: [step, {sequence: [step], name: inner}]": [
        "main/sequence",
        "main/step",
        "main/inner",
        "main/inner/step",
    ],
    "sequence: [until: {that: task.ticks > 1, max: 3, do: [step]}]": [
        "main/sequence",
        "main/until",
        "main/until/sequence",
        "main/until/step",
    ],
    "sequence: [repeat: {times: 2, do: {step: {}}}, repeat: {times: 2, do: {step: {}}}]": [
        "main/sequence",
        "main/repeat[0]",
        "main/repeat[0]/step",
        "main/repeat[1]",
        "main/repeat[1]/step",
    ],
    "sequence: [{repeat: {times: 2, do: {step: {}}}, name: twice}]": ["main/sequence", "main/twice", "main/twice/step"],
    "sequence: [sub, {sub: {}, name: again}]": [
        "main/sequence",
        "main/sub",
        "main/sub/sequence",
        "main/sub/step",
        "main/again",
        "main/again/sequence",
        "main/again/step",
    ],
    "sequence: [{timeout: 1 s, retry: 2, step: {}}]": [
        "main/sequence",
        "main/step:timeout:retry",
        "main/step:timeout",
        "main/step",
    ],
    "guard: {that: task.ticks < 9, name: soon}\nsequence: [step]": ["main/soon", "main/sequence", "main/step"],
    "sequence: [selector: [step], parallel: [{name: b, step: {}}, {name: c, step: {}}]]": [
        "main/sequence",
        "main/selector",
        "main/step",
        "main/parallel",
        "main/b",
        "main/c",
    ],
}
SUB = "sub: {in: {often: {type: int, default: 1}}, sequence: [step]}"


@pytest.mark.parametrize("body", PATHS)
def test_paths(task: Any, body: str) -> None:
    trees = SUB if "sub" in body else ""
    built = task.build(body, trees=trees)
    assert sorted(built.nodes) == sorted(PATHS[body])
    assert all(node.path == path and node.name == path.rpartition("/")[2] for path, node in built.nodes.items())
    assert next(path for _, path, _ in built.outline()) == PATHS[body][0]


def test_paths_are_the_same_for_everyone_and_every_time(task: Any) -> None:
    program = task.load("sequence: [step, selector: [step, sub]]\nfinally: [step]", trees=SUB)
    first, second = build(program, RunContext()), build(program, RunContext())
    assert list(first.nodes) == list(second.nodes)
    assert Paths().root(program.main.part, "main") == "main/sequence"
    assert [p for p in first.nodes if p.startswith("main/finally/")] == ["main/finally/step", "main/finally/sequence"]


def test_every_reference_has_nodes_and_cells_of_its_own(task: Any) -> None:
    text = "sequence: [&s {step: {script: RS}}, *s, sub, sub]"
    built = task.build(text, trees=SUB)
    nodes = list(built.nodes.values())
    assert len({id(node) for node in nodes}) == len(nodes) == 9
    for node in nodes:
        assert all(child.parent is node for child in node.children)


def test_two_builds_share_nothing(task: Any) -> None:
    program = task.load("keys: {a: Length}\nsequence: [set: {a: 1 mm}]")
    one, two = build(program, RunContext()), build(program, RunContext())
    assert not {id(n) for n in one.nodes.values()} & {id(n) for n in two.nodes.values()}
    assert not {id(c) for c in one.cells} & {id(c) for c in two.cells}


def test_cells_are_named_by_the_path_of_their_tree(task: Any) -> None:
    trees = "sub: {in: {d: Length}, out: {e: Length, spare: Length}, keys: {k: Length}, sequence: [set: {k: d, e: d, spare: d}]}"
    built = task.build("out: {r: Length}\nsequence: [sub: {d: 1 mm, e: $r}, sub: {d: 2 mm, e: $r}]", trees=trees)
    assert sorted(cell.name for cell in built.cells) == [
        "main/r",
        "main/sub[0]/k",
        "main/sub[0]/spare",
        "main/sub[1]/k",
        "main/sub[1]/spare",
    ]


def test_defaults_of_ports_inputs_and_keys(task: Any) -> None:
    trees = "sub: {in: {d: {type: Length, default: 4 mm}}, out: {e: Length}, sequence: [set: {e: d}]}"
    outcome = task.run(
        "out: {a: Length, b: {type: Length, default: 6 mm}}\nsequence: [measure: {length: $a}, sub, show: {value: $b}]",
        trees=trees,
    )
    assert outcome.status == "SUCCESS", outcome.reason
    assert task.output("a")[0] == 0.007
    assert task.did == "6"


def test_parameters_of_an_imported_file_are_those_of_its_prefix(task: Any) -> None:
    lib = """
format: stretch-tree/1
params: {step: {type: Length, default: 1 mm}}
trees: {show_step: {in: {n: {type: int, default: 1}}, sequence: [show: {value: $step}]}}
"""
    (task.folder / "lib.yaml").write_text(lib)
    head = "imports: {one: lib.yaml, two: lib.yaml}\nparams: {step: {type: Length, default: 9 mm}}"
    path = task.folder / "task.yaml"
    path.write_text(task.text("sequence: [one.show_step: {}, two.show_step: {}, show: {value: $step}]", head))
    context = RunContext()
    built = build(load_program(path, {"two.step": "5 mm"}).require(), context)
    assert Runner(built, context, VirtualClock(), period=0.05).run().status == "SUCCESS"
    assert task.did == "1 5 9"
    assert "main/show_step[0]/show" in built.nodes


def test_devices_and_readings_are_known_before_anything_is_opened(task: Any) -> None:
    body = "guard: arm.force < 5 N\nsequence: [lower: {by: 1 mm}, capture: {frame: $f}, check: arm.height > 0 mm]"
    built = task.build(body, "devices: {arm: Arm, camera: DepthCamera}\nkeys: {f: DepthFrame}")
    assert built.devices == {"arm", "camera"}
    assert built.readings == {"arm.force", "arm.height"}


def test_a_node_writes_only_its_outputs(task: Any) -> None:
    built = task.build("sequence: [measure: {}]")
    node = built.nodes["main/measure"]
    node.length = 0.002
    assert node.length == 0.002
    with pytest.raises(NodeError, match="cannot be written"):
        node.value = 1.0
