"""Types of names that no one declares: from what writes them, from the ports that they reach."""

from typing import Any

import pytest

from stretch_bt.tree.types import Family

#: body of `main` -> the key, its type
WRITTEN = {
    "sequence: [set: {x: 1 mm}, check: x > 0 mm]": ("x", "Length"),
    "sequence: [set: {x: 3}, check: x > 0]": ("x", "int"),
    "sequence: [set: {x: 3}, set: {x: x * 0.5}, check: x > 0]": ("x", "float"),
    "sequence: [set: {x: true}, check: x]": ("x", "bool"),
    "sequence: [set: {x: \"'slow'\"}, check: x == 'slow']": ("x", "str"),
    "sequence: [set: {x: [1 mm, 2 mm]}, check: x.0 > 0 mm]": ("x", "list[Length]"),
    "sequence: [set: {a: 1 mm}, set: {b: a / 2 s}, set: {x: b * 3}, check: x > 0 mm/s]": ("x", "Speed"),
    "sequence: [set: {x: y + 1 mm}, check: x > 0 mm]\nkeys: {y: {default: 2 mm}}": ("x", "Length"),
    "sequence: [for_each: {items: [1 N, 2 N], as: $x, do: {check: x > 0 N}}]": ("x", "Force"),
    "sequence: [for_each: {items: [1 N], as: $f, index: $x, do: {check: x < 3 and f > 0 N}}]": ("x", "int"),
    "sequence: [repeat: {times: 2, do: {set: {f: 1 N}}, collect: {x: $f}}, check: len(x) > 0]": ("x", "list[Force]"),
    "sequence: [measure: {length: $x}, check: x > 0 mm]": ("x", "Length"),
    "sequence: [measure: {length: $a, length_sd: $x}, check: a > x]": ("x", "Length"),
    "sequence: [measure: {length}, check: length > 0 mm]": ("length", "Length"),
    "sequence: [many: {some, none: $x}, check: len(x) < len(some)]": ("x", "list[Length]"),
    "sequence: [sub: {out_: $x}, check: x > 0 mm]": ("x", "Length"),
}
SUB = "sub: {out: [out_], sequence: [set: {y: 1 mm}, set: {out_: y * 2}]}"


@pytest.mark.parametrize("body", WRITTEN)
def test_a_key_has_the_type_of_what_writes_it(task: Any, body: str) -> None:
    program = task.load(body, trees=SUB if "sub" in body else "")
    name, type_ = WRITTEN[body]
    assert str(program.document.trees["main"].declared(name).type) == type_
    assert all(finding.severity != "error" for finding in program.diagnostics)


#: tree `sub` -> the type of its input, its bounds, and whether a caller may leave it out
REACHED = {
    "sub: {in: [x], sequence: [show: {value: $x}]}": ("Length", None, False),
    "sub: {in: {x: }, sequence: [show: {value: $x}]}": ("Length", None, False),
    "sub: {in: [value], sequence: [show: {value}]}": ("Length", None, False),
    "sub: {in: [x], sequence: [measure: {value: $x, length: $y}, check: y > 0 mm]}": ("Length", None, True),
    "sub: {in: [x], sequence: [measure: {value: $x, length: $y}, show: {value: $x}, check: y > 0 mm]}": (
        "Length",
        None,
        False,
    ),
    "sub: {in: [x], sequence: [inner: {x}]}\ninner: {in: {x: {type: Length, max: 9 mm}}, sequence: [show: {value: $x}]}": (
        "Length",
        0.009,
        False,
    ),
    "sub: {in: {x: {default: 2 N}}, sequence: [check: x > 1 N]}": ("Force", None, True),
}


@pytest.mark.parametrize("trees", REACHED)
def test_an_input_has_the_type_and_bounds_of_the_ports_that_it_reaches(task: Any, trees: str) -> None:
    type_, most, optional = REACHED[trees]
    ports = "" if optional else ("value: 1 mm" if "[value]" in trees else "x: 1 mm")
    program = task.load(f"sequence: [sub: {{{ports}}}]", trees=trees)
    [declared] = program.document.trees["sub"].ins.values()
    assert (str(declared.type), declared.has_default) == (type_, optional)
    assert declared.max == (None if most is None else pytest.approx(most))


def test_a_port_keeps_its_default_where_a_caller_leaves_its_input_out(task: Any) -> None:
    trees = "sub: {in: [value], out: [length], sequence: [measure: {value, length}]}"
    outcome = task.run("out: [a, b]\nsequence: [sub: {length: $a}, sub: {value: 3 mm, length: $b}]", trees=trees)
    assert outcome.status == "SUCCESS", outcome.reason
    assert (task.output("a")[0], task.output("b")[0]) == (pytest.approx(0.007), pytest.approx(0.003))


def test_names_resolve_from_the_key_to_the_input_to_the_param(task: Any) -> None:
    """An input hides a param of its name inside its tree."""
    head = "params: {x: {default: 1 mm}}"
    trees = "sub: {in: {x: Length}, sequence: [show: {value: $x}]}"
    task.run("sequence: [show: {value: $x}, sub: {x: 5 mm}, show: {value: x * 2}]", head, trees)
    assert task.did == "1 5 2"


def test_every_name_of_a_shipped_tree_has_a_type() -> None:
    from stretch_bt.tree.program import load_program, shipped_trees

    for tree in shipped_trees():
        for signature in load_program(tree).document.trees.values():
            types = {name: signature.declared(name).type.family for name in signature.names}  # type: ignore[union-attr]
            assert Family.ANY not in types.values(), (tree, signature.name, types)
