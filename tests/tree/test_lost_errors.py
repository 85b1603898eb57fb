"""Where the error of a value is lost in an expression, and where nobody would miss it."""

import pytest

from stretch_bt.tree.program import load_program

HEAD = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
trees:
  main:
    out: [OUT]
    sequence:
      - approach: {contact_height: $top}
      - measure_depth: {depth: $deep}
      - average_frames:
      - segment_contact:
      - fit_sphere: {sphere}
BODY
"""
LOOK = "  look: {out: {found: Length}, sequence: [set: {found: arm.height}]}\n"
ALL = "    keys: {all: {type: 'list[Length]', default: [1 mm]}}\n    sequence:\n"
#: an output and how it is set -> the names whose error is lost, nothing where none is or nobody asks
SETS = {
    "of a field": ("r", ["set: {r: 2 * sphere.radius}"], ["sphere.radius"]),
    "of an output": ("r", ["set: {r: top - 1 mm}"], ["top"]),
    "of several": ("r", ["set: {r: top + deep - sphere.radius}"], ["top", "deep", "sphere.radius"]),
    "of the larger": ("r", ["set: {r: 'max(top, deep)'}"], ["top", "deep"]),
    "of what a set handed on": ("r", ["set: {q: sphere.radius}", "set: {r: 2 * q}"], ["q"]),
    "of a called tree": ("r", ["look: {found: $q}", "set: {r: 2 * q}"], ["q"]),
    "with the error beside it": ("r", ["set: {r: 2 * top, r_sd: 2 * top_sd}"], []),
    "handed on": ("r", ["set: {r: top}"], []),
    "the mean of a list": ("r", ["set: {r: 'mean(all)'}"], []),
    "of a reading": ("r", ["set: {r: arm.height - 1 mm}"], []),
    "of the clock": ("r", ["set: {r: task.time}"], []),
    "a decision": ("r", ["set: {r: top > deep}"], []),
    "for a motion": ("top", ["set: {q: top / 2}", "lower: {by: $q}"], []),
    "for a port with an error": (
        "k",
        ["set: {d: top - deep}", "estimate_stiffness: {force: 1 N, deflection: $d, stiffness: $k}"],
        ["top", "deep"],
    ),
    "for a port whose error is given": (
        "k",
        [
            "set: {d: top - deep}",
            "estimate_stiffness: {force: 1 N, deflection: $d, deflection_sd: 0 mm, stiffness: $k}",
        ],
        [],
    ),
}


@pytest.mark.parametrize("case", SETS)
def test_a_set_that_loses_an_error_says_of_what(case):
    out, body, lost = SETS[case]
    lines = "".join(f"      - {line}\n" for line in body)
    text = HEAD.replace("OUT", out).replace("BODY\n", lines)
    text = text.replace("    sequence:\n", ALL, 1) if "mean(all)" in lines else text
    text += LOOK if "look" in lines else ""
    program = load_program("tree.yaml", text=text)
    assert program.errors == []
    found = [d for d in program.diagnostics if d.code == "deviation-lost"]
    assert len(found) == bool(lost), found
    for warning in found:
        assert warning.message.endswith(f"{', '.join(lost)} may have one")
        assert all(f"'{name}_sd'" in warning.hint for name in lost)
        assert warning.hint.startswith(("set 'r_sd' beside it", "set 'd_sd' beside it"))


def test_what_the_hint_says_to_write_gives_the_error(run):
    tree = """\
format: stretch-tree/1
trees:
  main:
    out: [c]
    sequence:
      - set: {a: 3 mm, a_sd: 0.3 mm, b: 1 mm, b_sd: 0.4 mm}
      - set: {c: a - b, c_sd: sqrt(a_sd * a_sd + b_sd * b_sd)}
"""
    result = run(tree)
    assert result.outputs["c"]["sd"] == pytest.approx(0.5)
