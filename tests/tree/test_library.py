"""Libraries of trees: they find the devices of whoever imports them, and a call gives their params."""

from pathlib import Path
from typing import Any

import pytest

from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.build import build
from stretch_bt.tree.program import Program, load_program

LIBRARY = """\
format: stretch-tree/1
imports: {inner: inner.yaml}
params: {most: {default: 5 N}, deep: {default: 3 mm, max: 9 mm}}
trees:
  go:
    in: [speed]
    guard: arm.force < most
    sequence: [lower: {by: $deep, speed}, inner.away]
"""
INNER = "format: stretch-tree/1\ntrees: {away: {sequence: [retract]}}\n"
TREE = """\
format: stretch-tree/1
imports: {{lib: lib.yaml}}
devices: {{arm: Arm, left: Arm}}
params: {{most: {{default: 4 N}}}}
trees:
  main:
    sequence:
      - check: most > 0 N
      - {call}
"""


@pytest.fixture
def load(tmp_path: Path) -> Any:
    (tmp_path / "lib.yaml").write_text(LIBRARY)
    (tmp_path / "inner.yaml").write_text(INNER)

    def loaded(call: str) -> Program:
        (tmp_path / "tree.yaml").write_text(TREE.format(call=call))
        return load_program(tmp_path / "tree.yaml")

    return loaded


#: a call -> step of the arm, the arm that moves, the readings that are asked for
CALLS = {
    "lib.go: {speed: 5 mm/s}": (0.003, "arm", {"arm.force"}),
    "lib.go: {speed: 5 mm/s, deep: 4 mm}": (0.004, "arm", {"arm.force"}),
    "lib.go: {speed: 5 mm/s, most}": (0.003, "arm", {"arm.force"}),
    "lib.go: {speed: 5 mm/s, arm: left}": (0.003, "left", {"left.force"}),
    "{run: lib.go, with: {arm: left, deep: 5 mm}}": (0.005, "left", {"left.force"}),
}


@pytest.mark.parametrize("call", CALLS)
def test_a_call_gives_params_and_devices(load: Any, call: str) -> None:
    depth, arm, readings = CALLS[call]
    program = load(call)
    assert [str(d) for d in program.diagnostics if d.severity == "error"] == []
    built = build(program, RunContext())
    lower, retract = built.nodes["main/go/lower"], built.nodes["main/go/away/retract"]
    assert (lower.by, lower.device_names["arm"], retract.device_names["arm"]) == (depth, arm, arm)
    assert built.readings == readings


#: a wrong call -> code, part of the message or hint
WRONG = {
    "lib.go: {speed: 5 mm/s, deep: 20 mm}": ("out-of-bounds", "9 mm"),
    "lib.go: {speed: 5 mm/s, deep: 3}": ("unit-missing", "3 mm"),
    "lib.go: {speed: 5 mm/s, deep: arm.height}": ("type-mismatch", "known at load"),
    "lib.go: {speed: 5 mm/s, arm: right}": ("device-undeclared", "takes Arm"),
    "lib.go: {speed: 5 mm/s, dep: 3 mm}": ("port-unknown", "'deep'"),
}


@pytest.mark.parametrize("call", WRONG)
def test_a_wrong_call_is_told_in_the_file_that_calls(load: Any, call: str) -> None:
    code, said = WRONG[call]
    [found] = load(call).errors
    assert (found.code, Path(found.file).name, found.line) == (code, "tree.yaml", 9)
    assert said in f"{found.message} {found.hint}"


def test_a_library_is_right_by_itself(load: Any, tmp_path: Path) -> None:
    load("retract")
    assert load_program(tmp_path / "lib.yaml").diagnostics == []


#: devices of the task, head of the library -> what is said and what to do
NOT_FOUND = {
    ("left: Arm, right: Arm", ""): (
        "'lower' needs a device of kind Arm, and this file declares none, and the task several, none of them called 'arm'",
        "call 'left' 'arm' in the task; a call may give another: 'lib.go: {arm: right}'",
    ),
    ("left: Arm", "devices: {arm: Arm}"): (
        "needs a device 'arm' of kind Arm, and this file declares none",
        "call 'left' 'arm' here, or leave out 'devices' in ",
    ),
}


@pytest.mark.parametrize(("devices", "head"), NOT_FOUND)
def test_a_library_whose_arm_has_another_name_says_what_to_call_it(tmp_path: Path, devices: str, head: str) -> None:
    message, hint = NOT_FOUND[devices, head]
    (tmp_path / "lib.yaml").write_text(
        f"format: stretch-tree/1\n{head}\ntrees: {{go: {{sequence: [lower: {{by: 1 mm}}]}}}}\n"
    )
    (tmp_path / "tree.yaml").write_text(
        f"format: stretch-tree/1\nimports: {{lib: lib.yaml}}\ndevices: {{{devices}}}\ntrees: {{main: {{sequence: [lib.go]}}}}\n"
    )
    [found] = load_program(tmp_path / "tree.yaml").errors
    assert message in found.message
    assert found.hint.startswith(hint)
