"""Edges of the language: what loops collect, absence in comparisons, null, names of outputs, records that are kept out."""

from pathlib import Path
from typing import Any

import pytest

from stretch_bt import check, run

#: a body -> how it ends
RUNS = {
    # a loop that collects a key leaves it as it is
    "keys: {look: {type: Length, default: none}}\nsequence:\n  - until: {that: look != none, max: 3, do: [check: look == none, "
    "set: {look: 1 mm}], collect: {looks: $look}}\n  - check: len(looks) == 1": "SUCCESS",
    "keys: {x: {default: 5 mm}}\nsequence:\n  - repeat: {times: 2, do: [{set: {x: 1 mm}, skip_if: x < 5 mm}], collect: {xs: $x}}\n"
    "  - check: len(xs) == 1": "SUCCESS",
    "sequence:\n  - repeat:\n      times: 2\n      collect: {outer: $x}\n      do:\n        - set: {x: 1 mm}\n"
    "        - {for_each: {items: [1, 2], as: $n, do: [{set: {x: n * 1 mm}, skip_if: n == 2}], collect: {inner: $x}}}\n"
    "  - check: len(outer) == 2 and len(inner) == 1": "SUCCESS",
    "sequence: [repeat: {times: 2, do: [set: {xs: []}, set: {x: 1 mm}], collect: {xs: $x}}, check: len(xs) == 1]": "SUCCESS",
    "sequence: [repeat: {times: 2, do: [set: {xs: none}, set: {x: 1 mm}], collect: {xs: $x}}, check: len(xs) == 1]": "SUCCESS",
    # an entry keeps its error
    "sequence:\n  - repeat: {times: 2, do: {measure: {length: $h}}, collect: {hs: $h}}\n"
    "  - for_each: {items: $hs, as: $each, do: [check: each_sd == 1 mm]}": "SUCCESS",
    # two names are equal, or are not, whether or not they are there
    "keys: {a: {type: Length, default: none}, b: {default: 1 mm}}\nsequence: [check: a != b]": "SUCCESS",
    "keys: {a: {type: Length, default: none}, b: {default: 1 mm}}\nsequence: [check: a == b]": "FAILURE",
    "keys: {a: {type: Length, default: none}, b: {type: Length, default: none}}\nsequence: [check: a == b]": "SUCCESS",
    "sequence:\n  - repeat: {times: 2, do: {measure: {value: 7 mm, length: $x}}, collect: {xs: $x}}\n"
    "  - check: max(xs) == at(xs, 1) and mean(xs) == x": "SUCCESS",
}


@pytest.mark.parametrize("body", RUNS)
def test_a_task_ends_so(task: Any, body: str) -> None:
    outcome = task.run(body)
    assert outcome.status == RUNS[body], outcome.reason


def test_text_is_a_name_only_where_it_is_one_alone(task: Any) -> None:
    trees = "say: {in: {text: {type: str}}, sequence: [check: \"text == '$5 are due' or text == 'a'\"]}"
    for given in ("$5 are due", "$held"):
        outcome = task.run(f"keys: {{held: {{default: a}}}}\nsequence: [say: {{text: '{given}'}}]", trees=trees)
        assert outcome.status == "SUCCESS", outcome.reason


def test_a_text_of_a_value_without_an_answer_fails_nothing(task: Any) -> None:
    """It turned the node that it is written beside into a FAILURE."""
    trees = "sub: {in: {d: {type: Length, max: 5 mm}}, sequence: [{check: 1 < 2, log: it is $d}]}"
    outcome = task.run("keys: {e: {default: 4 mm}}\nsequence: [set: {e: 2 * e}, sub: {d: $e}]", trees=trees)
    assert outcome.status == "SUCCESS", outcome.reason


def test_a_tree_gives_the_error_of_an_output(task: Any) -> None:
    trees = "look: {out: [length], sequence: [measure: {length}]}"
    assert task.run("out: [d, s]\nsequence: [look: {length: $d, length_sd: $s}]", trees=trees).status == "SUCCESS"
    assert (task.output("d")[0], task.output("s")[0]) == (0.007, 0.001)
    assert task.run("out: [s]\nsequence: [look: {length_sd: $s}]", trees=trees).status == "SUCCESS"
    assert task.output("s")[0] == 0.001


def test_an_output_of_a_list_is_declared_among_the_keys(task: Any) -> None:
    task.run("out: [x]\nkeys: {x: {type: Length, unit: m, doc: width}}\nset: {x: 1 mm}")
    declared, cell = task.built.outputs["x"]
    assert (declared.unit, declared.doc, cell.value) == ("m", "width", 0.001)


HEAD = "format: stretch-tree/1\ndevices: {arm: Arm, gripper: Gripper, camera: DepthCamera}\n"
#: trees -> the codes of what is found
FOUND = {
    "main: {sequence: [set: {x: null}, check: x == none]}": ["value-missing"],
    "main: {sequence: [set: {x: {y}}, check: x > 1]}": ["type-mismatch"],
    "main: {sequence: [approach: null]}": ["value-missing"],
    "main: {sequence: [approach: ~]}": ["value-missing"],
    "main: {out: {x: Length}, keys: {x: Length}, set: {x: 1 mm}}": ["key-duplicate"],
    "main: {sequence: [repeat: {times: 2, keys: {mean: {default: 0}}, do: [wait: {duration: 1 s}]}]}": [
        "key-duplicate"
    ],
    "main: {sequence: [repeat: {times: 2, keys: {none: {default: 0}}, do: [wait: {duration: 1 s}]}]}": [
        "key-duplicate"
    ],
    "main: {sequence: [approach, leave]}\n  leave: {sequence: [retract: {clearance: 20 mm}]}": ["record-kept-out"],
    "main: {sequence: [leave, approach]}\n  leave: {sequence: [retract: {clearance: 20 mm}]}": [],
    "main: {sequence: [approach, leave]}\n  leave: {in: [touch], sequence: [retract: {clearance: 20 mm}]}": [],
    "main: {sequence: [approach, leave]}\n  leave: {sequence: [retract: {clearance: 20 mm, touch: none}]}": [],
    "main: {out: [r], sequence: [capture: {frame}, average_frames, segment_contact, fit_sphere: {sphere}, set: {r: sphere.radius}]}": [
        "record-written-over"
    ],
}


@pytest.mark.parametrize("trees", FOUND)
def test_what_is_found(tmp_path: Path, trees: str) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(f"{HEAD}trees:\n  {trees}\n")
    assert [found.code for found in check(path) if found.code != "device-unused"] == FOUND[trees]


HEAD = "format: stretch-tree/1\ndevices: {arm: Arm, gripper: Gripper, camera: DepthCamera}\n"
#: file -> the codes that a check gives
CHECKED = {
    "a bare node under force_success reads": (
        HEAD + "trees: {main: {sequence: [capture, {force_success: segment_contact}]}}\n",
        [],
    ),
    "a skip_if without an answer fails before its body": (
        HEAD
        + "trees: {main: {keys: {felt: {type: Felt, default: none}}, sequence: [selector: [{sequence: [set: {tries: 1}, wait: {duration: 1 s}],"
        " skip_if: felt.deflection > 1 mm}, {set: {n: tries + 1}}], check: n > 0]}}\n",
        ["read-before-write"],
    ),
    "what follows a skip_if that may fail is reached": (
        HEAD + "trees: {main: {sequence: [selector: [{set: {m: 1}, skip_if: arm.force > 1 N}, {set: {m: 2}}]]}}\n",
        [],
    ),
    "a key of a loop is unset as the loop begins": (
        HEAD
        + "trees: {main: {sequence: [set: {best: 0 mm}, {repeat: {times: 2, keys: {best: Length}, do: {set: {best: best + 1 mm}}}}]}}\n",
        ["read-before-write"],
    ),
    "a list that a loop collects into a key of its own is there": (
        HEAD
        + "trees: {main: {sequence: [until: {that: len(xs) >= 2, max: 3, keys: {xs: {type: 'list[Length]'}}, collect: {xs: $x},"
        " do: [set: {x: 1 mm}]}, check: len(xs) > 0]}}\n",
        [],
    ),
    "a parallel without children": (
        HEAD + "trees: {main: {parallel: {policy: success_on_selected, selected: press, children: []}}}\n",
        ["empty", "type-mismatch"],
    ),
    "a quotient": (
        HEAD + "trees: {main: {sequence: [set: {n: 4}, {set: {x: 0.1/n, y: 11/n}}, check: x + y > 0]}}\n",
        [],
    ),
}


@pytest.mark.parametrize("name", CHECKED)
def test_a_check_says_what_a_run_does(name: str, tmp_path: Path) -> None:
    text, codes = CHECKED[name]
    (tmp_path / "tree.yaml").write_text(text)
    found = [d for d in check([tmp_path / "tree.yaml"]) if d.severity == "error"]
    assert sorted({d.code for d in found}) == codes, found


def test_the_reasons_of_a_called_tree_and_of_its_finally_are_both_told(tmp_path: Path) -> None:
    (tmp_path / "tree.yaml").write_text(
        "format: stretch-tree/1\ntrees:\n  main: {sequence: [t: {}]}\n"
        "  t: {sequence: [fail: the dough sticks], finally: [wait: {duration: 0.1 s}, fail: the hand is low]}\n"
    )
    result = run(tmp_path / "tree.yaml", mocks={"format": "stretch-mocks/1", "tree": "tree.yaml", "mocks": []})
    assert result.status == "FAILURE"
    assert "main/t/fail: the dough sticks; its finally failed: main/t/finally/fail: the hand is low" in result.reason


def test_the_error_of_a_field_of_an_item_reaches_a_called_tree(tmp_path: Path) -> None:
    (tmp_path / "tree.yaml").write_text(
        "format: stretch-tree/1\ntrees:\n  main:\n    out: [y]\n    sequence:\n"
        "      - repeat: {times: 2, do: [set: {x: 2 mm, x_sd: 0.5 mm}], collect: {xs: $x}}\n"
        "      - t: {xs: $xs, y: $y}\n"
        "  t: {in: {xs: {type: 'list[Length]', min: 0 mm}}, out: [y], sequence: [set: {y: $xs.0}]}\n"
    )
    result = run(tmp_path / "tree.yaml", mocks={"format": "stretch-mocks/1", "tree": "tree.yaml", "mocks": []})
    assert result.outputs["y"] == {"value": 2.0, "unit": "mm", "sd": 0.5}, result.reason


def test_texts_given_from_python_keep_their_commas(tmp_path: Path) -> None:
    (tmp_path / "tree.yaml").write_text(
        "format: stretch-tree/1\nparams: {names: {type: 'list[str]', default: []}}\n"
        "trees: {main: {out: [n], sequence: [set: {n: len(names)}]}}\n"
    )
    mocks = {"format": "stretch-mocks/1", "tree": "tree.yaml", "mocks": []}
    result = run(tmp_path / "tree.yaml", params={"names": ["a, b", "c: [d]", "true"]}, mocks=mocks)
    assert result.outputs["n"]["value"] == 3
