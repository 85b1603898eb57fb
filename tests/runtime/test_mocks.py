"""What mocks do to a run of an unedited tree: time, outputs, statuses, conditions, readings and expectations."""

import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from py_trees.common import Status

from stretch_bt import run
from stretch_bt.errors import InvalidInput, MocksError
from stretch_bt.hardware.interfaces import INTERFACES
from stretch_bt.perception import Sphere
from stretch_bt.runtime.check import check
from stretch_bt.runtime.expectation import command_names
from stretch_bt.runtime.mock_node import pattern_fits
from stretch_bt.runtime.mock_value import mock_value
from stretch_bt.runtime.replay import replay
from stretch_bt.source import parse
from stretch_bt.tree.port_check import PortCheck
from stretch_bt.tree.types import from_annotation
from stretch_bt.units import Estimate

TREE = """
format: stretch-tree/1
tick: 100 ms
devices: {arm: Arm, camera: DepthCamera}
keys: {height: Length, frame: DepthFrame, contact: Contact, sphere: Sphere, passes: {type: int, default: 0}}
trees:
  main:
    out: {top: {type: Length, default: 0 mm}, top_sd: {type: Length, default: 0 mm}, seen: {type: int, default: 0}}
    guard: {that: "arm.force < 5 N", name: force_limit}
    sequence:
      - {name: press, lower: {by: 1 mm}}
      - until:
          that: passes >= 3
          max: 9
          do:
            sequence:
              - selector: [look: {height: $height}, set: {height: 99 mm}]
              - set: {passes: passes + 1, top: height}
      - check: {that: "top > 2 mm", name: high}
    finally: [retract: {clearance: 20 mm}]
  look:
    out: {height: Length}
    keys: {frame: DepthFrame, contact: Contact}
    sequence:
      - capture: {frame: $frame}
      - segment_contact: {frame: $frame, contact: $contact}
      - track_height: {frame: $frame, contact: $contact, height: $height}
"""
MOCKS = """
format: stretch-mocks/1
tree: tree.yaml
mocks:
  - {{match: "**/press"}}
  - {{match: "**/retract"}}
{rules}
readings: {{arm.force: {force}}}
expect: {{{expect}}}
"""


@pytest.fixture
def mocked(run: Any) -> Any:
    def make(*rules: str, force: str = "1 N", expect: str = "") -> Any:
        rows = "\n".join(f"  - {{{rule}}}" for rule in rules or ("match: main/until/look, outputs: {height: 3 mm}",))
        return run(TREE, mocks=MOCKS.format(rules=rows, force=force, expect=expect))

    return make


LOOK = "match: main/until/look"
#: rule -> how the run ends, the last height, mm
RULES = {
    f"{LOOK}, outputs: {{height: 3 mm}}": ("SUCCESS", 3.0),
    f"{LOOK}, outputs: {{height: [1 mm, 2 mm, 4 mm]}}": ("SUCCESS", 4.0),
    f"{LOOK}, outputs: {{height: [1 mm, 4 mm]}}": ("SUCCESS", 4.0),
    f"{LOOK}, outputs: {{height: [4 mm, 1 mm]}}": ("FAILURE", 1.0),
    f"{LOOK}, outputs: {{height: [4 mm, 1 mm]}}, then: cycle": ("SUCCESS", 4.0),
    f"{LOOK}, outputs: {{height: [4 mm, 1 mm]}}, then: fail": ("SUCCESS", 99.0),
    f"{LOOK}, status: failure": ("SUCCESS", 99.0),
    f"{LOOK}, status: [failure, failure, success], outputs: {{height: 3 mm}}": ("SUCCESS", 3.0),
    f"{LOOK}, status: [failure, success], outputs: {{height: [1 mm, 1 mm, 4 mm]}}": ("SUCCESS", 4.0),
    f"{LOOK}, status: [success, failure], outputs: {{height: 3 mm}}": ("SUCCESS", 99.0),
    f"{LOOK}, status_when: passes > 1, outputs: {{height: 3 mm}}": ("SUCCESS", 3.0),
    f"{LOOK}, status_when: passes < 2, outputs: {{height: 3 mm}}": ("SUCCESS", 99.0),
}


@pytest.mark.parametrize("rule", RULES)
def test_outputs_and_statuses(mocked: Any, rule: str) -> None:
    result = mocked(rule)
    status, height = RULES[rule]
    assert result.status == status, result.reason
    assert result.outputs["top"]["value"] == pytest.approx(height) if status == "SUCCESS" else "top" in result.outputs


FOUR_STARTS = """
format: stretch-tree/1
trees:
  main:
    out: [counts, words]
    repeat: {times: 4, do: {force_success: {look: {count, word}}}, collect: {counts: $count, words: $word}}
  look:
    out: [count, word]
    set: {count: 9, word: "'w'"}
"""
#: mock -> the counts and the words that four starts write, of those that succeed
ENDS = {
    "outputs: {count: [1, 2, 3], word: [a, b]}, then: fail": ([1, 2], ["a", "b"]),
    "outputs: {count: [1], word: [a, b, c]}, then: fail": ([1], ["a"]),
    "outputs: {count: [1, 2, 3], word: a}, then: fail": ([1, 2, 3], ["a", "a", "a"]),
    "outputs: {count: 1, word: a}, then: fail": ([1], ["a"]),
    "status: [success, success], outputs: {count: [1, 2, 3], word: a}, then: fail": ([1, 2], ["a", "a"]),
    "status_when: task.ticks > 0, outputs: {count: [1, 2, 3], word: [a, b]}, then: fail": ([1, 2], ["a", "b"]),
    "status: [success, failure], outputs: {count: [1, 2, 3], word: a}, then: cycle": ([1, 3], ["a", "a"]),
    "outputs: {count: [1, 2, 3], word: [a, b]}, then: cycle": ([1, 2, 3, 1], ["a", "b", "a", "b"]),
    "outputs: {count: [1, 2, 3], word: [a, b]}": ([1, 2, 3, 3], ["a", "b", "b", "b"]),
}


@pytest.mark.parametrize("rest", ENDS)
def test_what_comes_after_the_end_of_a_list(run: Any, rest: str) -> None:
    mocks = f"format: stretch-mocks/1\ntree: tree.yaml\nmocks: [{{match: '**/look', {rest}}}]\n"
    result = run(FOUR_STARTS, mocks=mocks)
    assert result.status == "SUCCESS", result.reason
    assert (result.keys["counts"], result.keys["words"]) == ENDS[rest]


def test_a_mock_takes_its_time_on_the_clock_of_the_run(mocked: Any) -> None:
    quick = mocked(f"{LOOK}, outputs: {{height: 3 mm}}")
    slow = mocked(f"{LOOK}, outputs: {{height: 3 mm}}, after: 0.5 s")
    assert slow.task_seconds - quick.task_seconds == pytest.approx(1.5)
    assert slow.wall_seconds < 5


def test_mocks_of_another_tree_are_one_mistake() -> None:
    shipped = Path(__file__).parents[1] / "trees" / "mocks" / "palpate_stiffness_success.yaml"
    with pytest.raises(
        MocksError, match="for the tree 'palpate_stiffness' and match no node of 'watch_contact'"
    ) as told:
        run("watch_contact", mocks=shipped)
    assert len(told.value.diagnostics) == 1


def test_parts_of_a_called_tree_are_mocked_one_by_one(mocked: Any) -> None:
    result = mocked(
        'match: "**/capture", outputs: {frame: {time: 1 s}}',
        'match: "**/segment_contact", outputs: {contact: {}}',
        'match: "**/track_height", outputs: {height: {value: 3 mm, sd: 0.1 mm}}',
    )
    assert result.status == "SUCCESS", result.reason


def test_the_message_of_a_failure_is_its_reason(mocked: Any) -> None:
    result = mocked("match: main/high, status: failure, message: not high enough", f"{LOOK}, outputs: {{height: 3 mm}}")
    assert (result.status, result.reason) == ("FAILURE", "main/high: not high enough")


def test_a_guard_is_mocked_by_its_path_and_its_body_runs(mocked: Any) -> None:
    result = mocked(
        "match: main/force_limit, status: [success, success, failure]", f"{LOOK}, outputs: {{height: 3 mm}}"
    )
    assert result.status == "FAILURE"
    assert "main/force_limit" in result.reason


def test_readings_are_given_one_after_the_other(mocked: Any) -> None:
    assert mocked(force="[1 N, 2 N, 9 N]").status == "FAILURE"
    result = mocked(force="[1 N, 2 N, 9 N]")
    assert "arm.force = 9 N" in result.reason
    assert mocked(force="[1 N, 2 N]").status == "SUCCESS"


#: expectation -> part of what is unmet
EXPECTATIONS = {
    "result: success": None,
    "result: failure": "expected failure",
    "visited: [main/until/look, main/finally/retract#success]": None,
    "visited: [main/high#failure]": "visit of main/high#failure",
    "never: [main/high#failure]": None,
    'never: ["**/look"]': "no visit of **/look",
    "ticks_max: 99": None,
    "ticks_max: 1": "at most 1",
}


@pytest.mark.parametrize("expect", EXPECTATIONS)
def test_what_was_expected_and_did_not_come_true_is_said(mocked: Any, expect: str) -> None:
    result = mocked(expect=expect)
    said = EXPECTATIONS[expect]
    assert len(result.unmet) == (said is not None)
    assert said is None or said in result.unmet[0]


def test_an_output_that_a_mock_does_not_give_is_named_where_it_is_read(mocked: Any) -> None:
    result = mocked(LOOK)
    assert result.status == "ERROR"
    assert "height" in result.reason
    assert "mock of main/until/look" in result.reason


def test_a_field_that_a_mock_does_not_give_is_named_where_it_is_read(run: Any) -> None:
    tree = """
format: stretch-tree/1
devices: {camera: DepthCamera}
keys: {f: DepthFrame}
trees: {main: {sequence: [capture: {frame: $f}, check: f.stretch > 0 mm]}}
"""
    mocks = """
format: stretch-mocks/1
tree: tree.yaml
mocks: [{match: main/capture, outputs: {frame: {time: 1 s}}}]
"""
    result = run(tree, mocks=mocks)
    assert result.status == "ERROR"
    assert "has no 'stretch'" in result.reason


FITS = [
    ("main/press", "main/press", True),
    ("main/press", "main/press[1]", True),
    ("main/press[1]", "main/press[1]", True),
    ("main/press[1]", "main/press[2]", False),
    ("main/press", "main/press_deeper", False),
    ("main/press*", "main/press_deeper", True),
    ("**/press", "main/press", True),
    ("**/press", "main/until/sub/press[3]", True),
    ("**/press", "main/press/deeper", False),
    ("main/*/press", "main/until/press", True),
    ("main/*/press", "main/press", False),
    ("main/*/press", "main/a/b/press", False),
    ("main/**", "main/a/b", True),
    ("main/**/press", "main/press", True),
    ("press", "main/press", False),
    ("main/step:retry", "main/step:retry", True),
    ("main/pr.ss", "main/press", False),
]


@pytest.mark.parametrize(("pattern", "path", "fits"), FITS)
def test_patterns(pattern: str, path: str, fits: bool) -> None:
    assert pattern_fits(pattern, path) is fits


PATTERNS = st.lists(st.sampled_from(["**", "*", "a", "ab", "a*", "*b", "a[1]", "*a*b*", "b"]), min_size=1, max_size=5)
PATHS = st.lists(st.sampled_from(["a", "ab", "b", "a[1]", "ab[2]", "aab", "bb[10]"]), min_size=1, max_size=5)


def by_regex(pattern: str, path: str) -> bool:
    """Return what a pattern means, as a regular expression says it, whose time has no bound."""
    regex = ""
    for segment in pattern.split("/"):
        index = "" if segment.endswith("]") else r"(?:\[[0-9]+\])?"
        inner = re.escape(segment).replace(r"\*", "[^/]*") + index + "/"
        regex += r"(?:[^/]+/)*" if segment == "**" else inner
    return re.fullmatch(regex, path + "/") is not None


@given(PATTERNS.map("/".join), PATHS.map("/".join))
def test_a_pattern_means_the_paths_of_its_regular_expression(pattern: str, path: str) -> None:
    assert pattern_fits(pattern, path) == by_regex(pattern, path)


@pytest.mark.parametrize("pattern", ["**/" * 300 + "b", "a*" * 400 + "b", "/".join(["**", "*a*"] * 150)])
def test_no_pattern_takes_long(pattern: str) -> None:
    assert not pattern_fits(pattern, "/".join(["a" * 200] * 100))  # the regular expression hangs


#: a rule or expectation, the code of its error, and what is said
ODD = {
    "match: ''": ("value", "this one is empty"),
    "match: [main/press]": ("type-mismatch", "'match' takes one pattern"),
    "match: {press: 1}": ("type-mismatch", "'match' takes one pattern"),
    f"match: '{'**/' * 400}press'": ("value", "at most 1000 characters"),
    "match: main/until/look, outputs: {height: {value: 1 mm, sd: -1 mm}}": ("out-of-bounds", "not below 0"),
}


@pytest.mark.parametrize("rule", ODD)
def test_an_odd_rule_is_refused_in_its_place(rule: str, mocked: Any) -> None:
    code, told = ODD[rule]
    with pytest.raises(MocksError, match=told) as refused:
        mocked(rule)
    assert code in {d.code for d in refused.value.diagnostics}


def test_a_file_has_some_hundred_mocks_and_a_few_suggestions(mocked: Any) -> None:
    with pytest.raises(MocksError, match="has 602 entries; 500 are read"):
        mocked(*["match: main/presss"] * 600)
    with pytest.raises(MocksError) as refused:
        mocked(*(f"match: main/until/loook{k}" for k in range(400)))
    assert sum("did you mean" in d.hint for d in refused.value.diagnostics) <= 20


def test_a_library_has_nothing_to_mock(tmp_path: Path) -> None:
    (tmp_path / "lib.yaml").write_text(
        "format: stretch-tree/1\ntrees:\n  feel:\n    in: {a: Length}\n    check: a > 0 mm\n"
    )
    (tmp_path / "mocks.yaml").write_text("format: stretch-mocks/1\ntree: lib.yaml\nmocks: [{match: '**/press'}]\n")
    [found] = check(tmp_path / "mocks.yaml")
    assert (found.code, found.line) == ("tree-wrong", 2)
    assert "library" in found.message


def test_mocks_that_never_end_are_ended(mocked: Any) -> None:
    found = mocked("match: main/until/look, status: running", expect="ticks_max: 20")
    assert found.status == "FAILURE"
    assert "no end after 200 ticks" in found.reason


def test_a_start_that_is_to_run_on_does_so_until_it_is_stopped(tmp_path: Path) -> None:
    """It ran for one tick, though a list has one status for each start."""
    body = "retry: {attempts: 2, do: {timeout: 1 s, wait: {duration: 9 s}}}"
    (tmp_path / "tree.yaml").write_text(f"format: stretch-tree/1\ntrees: {{main: {{{body}}}}}\n")
    mocks = {"mocks": [{"match": "**/wait", "status": ["running", "success"]}]}
    found = run(tmp_path / "tree.yaml", mocks=mocks, record="none")
    assert (found.status, found.ticks) == ("SUCCESS", 22)


def test_a_mock_of_a_construct_gives_the_keys_that_are_written_in_it(tmp_path: Path) -> None:
    """They were once reported as outputs that it does not write."""
    tree = """
format: stretch-tree/1
trees:
  main:
    sequence:
      - set: {n: 1 mm}
      - repeat: {times: 2, do: [wait: {duration: 1 s}, set: {v: 1 mm}], collect: {all: $v}}
      - check: {that: n == 3 mm and sum(all) == 9 mm and v == 5 mm, else: $n $all $v}
"""
    (tmp_path / "tree.yaml").write_text(tree)
    mocks = [
        {"match": "main/set", "outputs": {"n": "3 mm"}},
        {"match": "main/repeat", "outputs": {"v": "5 mm", "all": [["4 mm", "5 mm"]]}},
    ]
    found = run(tmp_path / "tree.yaml", mocks={"mocks": mocks}, record="none")
    assert (found.status, found.ticks) == ("SUCCESS", 1), found.reason


def test_what_a_mock_writes_passes_a_node_that_hands_it_on() -> None:
    value = mock_value(parse("{radius: 5 mm}", "mocks.yaml"), from_annotation(Sphere), "sphere")
    assert PortCheck(Sphere, None, None).judge(value) is value


@pytest.mark.parametrize("form", ["file", "text", "mapping"])
def test_mocks_are_a_file_its_text_or_a_mapping(run: Any, tmp_path: Path, form: str) -> None:
    rules = [
        {"match": "**/press"},
        {"match": "**/retract"},
        {"match": "**/look", "status": (Status.SUCCESS, Status.FAILURE), "outputs": {"height": ["3 mm", "4 mm"]}},
    ]
    mapping = {
        "mocks": rules,
        "readings": {"arm.force": "1 N"},
        "expect": {"result": "success", "visited": ["main/high"]},
    }
    text = MOCKS.format(
        rules='  - {match: "**/look", status: [success, failure], outputs: {height: [3 mm, 4 mm]}}',
        force="1 N",
        expect="result: success, visited: [main/high]",
    )
    (tmp_path / "mocks.yaml").write_text(text, encoding="utf-8")
    mocks = {"file": tmp_path / "mocks.yaml", "text": text, "mapping": mapping}[form]
    result = run(TREE, mocks=mocks)
    assert (result.status, result.unmet, result.outputs["top"]["value"]) == ("SUCCESS", [], 99.0)
    [look] = [path for path in result.visited if path.endswith("/look")]
    assert result.visited[look] == ("SUCCESS", "FAILURE")
    assert result.keys["passes"] == 3
    assert replay(result.record).identical


@pytest.mark.parametrize("many", [False, True])
def test_an_estimate_in_a_mapping_is_in_si(run: Any, many: bool) -> None:
    found, radius = Estimate(0.003, 0.0001), Estimate(0.03, 0.001)
    mocks = {
        "mocks": [
            {"match": "main/measure", "outputs": {"height": [found] if many else found}},
            {"match": "main/fit_sphere", "outputs": {"sphere": {"radius": radius}}},
        ]
    }
    tree = """\
format: stretch-tree/1
devices: {camera: DepthCamera}
trees:
  main:
    out: [height, r]
    sequence: [measure: {height}, capture, segment_contact, fit_sphere: {sphere}, set: {r: sphere.radius}]
  measure: {out: {height: Length}, set: {height: 1 mm}}
"""
    mocks["mocks"] += [{"match": "main/capture"}, {"match": "main/segment_contact"}]
    outcome = run(tree, mocks=mocks)
    assert outcome.outputs["height"] == {"value": 3.0, "unit": "mm", "sd": 0.1}
    assert outcome.keys["r"] == pytest.approx(0.03)


def test_a_mistake_in_a_mapping_is_told_like_one_in_a_file(run: Any) -> None:
    with pytest.raises(InvalidInput, match=re.escape("mocks[0].outputs.height is ")):
        run(TREE, mocks={"mocks": [{"match": "**/look", "outputs": {"height": Path("x")}}]})
    with pytest.raises(MocksError, match="'macth'"):
        run(TREE, mocks={"mocks": [{"macth": "**/press"}]})
    with pytest.raises(MocksError, match="did you mean"):
        run(TREE, mocks={"mocks": [{"match": "**/presss"}]})


MEASURED = """
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper}
params: {speed: {type: Speed, default: 10 mm/s}}
trees:
  main:
    out: {k: Stiffness, n: int, line: {type: "list[Length]", default: [1 mm, 2 mm]}, name: str, share: float}
    sequence:
      - set: {k: 1.04 N/mm, n: 3, name: "'slow'", share: 0.5}
      - {name: up, retract: {clearance: 20 mm, speed}}
      - set_stretch: {stretch: 0 mm}
      - {name: down, lower: {by: 1 mm}}
"""
#: expectation -> part of what is unmet
MEASUREMENTS = {
    "outputs: {k: {value: 1 N/mm, within: 5 %}}": None,
    "outputs: {k: {value: 1 N/mm, within: 0.041 N/mm}}": None,
    "outputs: {k: {value: 1 N/mm, within: 3 %}}": "expected k to be 1 N/mm within 3 %; it is 1.04 N/mm",
    "outputs: {k: {value: 1 N/mm, within: 0.039 N/mm}}": "within 0.039 N/mm; it is 1.04 N/mm",
    "outputs: {k: 1040 N/m, n: 3, name: slow}": None,
    "outputs: {n: 4}": "expected n to be 4; it is 3",
    "outputs: {share: {value: 0.4, within: 0.05}}": "expected share to be 0.4 within 0.05; it is 0.5",
    "outputs: {share: 50 %}": None,
    "outputs: {name: quick}": "expected name to be quick; it is slow",
    "outputs: {line: [1 mm, 2 mm]}": None,
    "outputs: {line: {value: [1.1 mm, 2.1 mm], within: 10 %}}": None,
    "outputs: {line: [1 mm]}": "expected line to be [1 mm]; it is [1 mm, 2 mm]",
    "commands: [arm.move, gripper.move, arm.move]": None,
    "commands: [arm.move, arm.move]": None,
    "commands: [gripper.move]": None,
    "commands: []": None,
    "commands: [gripper.move, arm.move, arm.move]": "expected arm.move after arm.move; commanded were arm.move, gripper",
    "commands: [arm.follow]": "expected arm.follow; commanded were arm.move, gripper.move, arm.move",
}


@pytest.mark.parametrize("expect", MEASUREMENTS)
def test_outputs_and_commands_are_expected(run: Any, scripted_device: Any, expect: str) -> None:
    mocks = f"format: stretch-mocks/1\ntree: tree.yaml\nexpect: {{{expect}}}\n"
    result = run(MEASURED, mocks=mocks, devices={"arm": scripted_device("Arm"), "gripper": scripted_device("Gripper")})
    assert result.status == "SUCCESS", result.reason
    said = MEASUREMENTS[expect]
    assert len(result.unmet) == (said is not None), result.unmet
    assert said is None or said in result.unmet[0]


LISTED = """
format: stretch-tree/1
trees: {main: {out: {line: "list[Length]"}, sequence: [{name: drawn, set: {line: [1 mm]}}]}}
"""
#: what a mock gives an output that is a list -> what to write instead; None where it is taken
LISTS = {
    "[[2 mm]]": None,
    "2 mm": "[[2 mm]]",
    "[2 mm]": "[[2 mm]]",
    "[2 mm, 3 mm]": "[[2 mm, 3 mm]]",
    "[[2 mm], 3 mm]": "[3 mm]",
    "[{a: 1}]": "[[10 mm]]",
    "[2 N]": "[[10 mm]]",
}


@pytest.mark.parametrize("given", LISTS)
def test_an_output_that_is_a_list_is_told_its_brackets(run: Any, given: str) -> None:
    def ran(line: str) -> Any:
        rule = f"{{match: '**/drawn', outputs: {{line: {line}}}}}"
        return run(LISTED, mocks=f"format: stretch-mocks/1\ntree: tree.yaml\nmocks: [{rule}]\n")

    wanted = LISTS[given]
    if wanted is None:
        assert ran(given).status == "SUCCESS"
        return
    with pytest.raises(MocksError) as refused:
        ran(given)
    [found] = refused.value.diagnostics
    assert f"write '{wanted}'" in found.hint
    assert ran(given.replace("3 mm", wanted) if "[[" in given else wanted).status == "SUCCESS"


def test_an_output_that_the_run_never_gave_is_unmet(run: Any) -> None:
    tree = (
        "format: stretch-tree/1\ntrees: {main: {out: {a: Length}, sequence: [wait: {duration: 1 s}, set: {a: 1 mm}]}}\n"
    )
    fails = {"match": "**/wait", "status": "failure"}
    result = run(tree, mocks={"mocks": [fails], "expect": {"outputs": {"a": "1 mm"}}})
    assert result.unmet == ["expected a to be 1 mm; the run gave none"]


def test_every_kind_of_device_has_commands_or_none() -> None:
    found = {name: set(command_names(interface)) for name, interface in INTERFACES.items()}
    assert found == {
        "Arm": {"move", "follow", "stop"},
        "Gripper": {"move", "stop"},
        "DepthCamera": set(),
        "ForceSensor": {"zero"},
        "Operator": {"mount", "confirm", "stop"},
    }


@pytest.mark.parametrize(
    ("rest", "named"),
    [
        ("[check: gripper.opening > 1 mm]", "'gripper.opening'"),
        ("[lower: {by: 1 mm}, check: gripper.opening > 1 mm]", "'main/lower' and 1 more"),
    ],
)
def test_what_no_mock_stands_for_is_named(rest, named, tmp_path):
    (tmp_path / "tree.yaml").write_text(
        f"format: stretch-tree/1\ndevices: {{arm: Arm, gripper: Gripper}}\ntrees: {{main: {{sequence: {rest}}}}}\n"
    )
    with pytest.raises(InvalidInput, match=f"no mock stands for {named}: mock it, or name a scene"):
        run(tmp_path / "tree.yaml", mocks={"mocks": []}, record="none")


@pytest.mark.parametrize(
    ("meant", "noted"), [("tree.yaml", False), ("lib/tree.yaml", False), ("palpate_stiffness", True)]
)
def test_mocks_for_another_tree_are_noted(tmp_path: Path, meant: str, noted: bool) -> None:
    (tmp_path / "tree.yaml").write_text("format: stretch-tree/1\ntrees: {main: {wait: {duration: 1 s}}}\n")
    (tmp_path / "m.yaml").write_text(f"format: stretch-mocks/1\ntree: {meant}\nmocks: [{{match: main/wait}}]\n")
    result = run(tmp_path / "tree.yaml", mocks=tmp_path / "m.yaml", record="none")
    assert result.status == "SUCCESS"
    wanted = "m.yaml:2:7 warning[tree-wrong]: these mocks are for the tree 'palpate_stiffness', and this run is of 'tree.yaml'"
    assert [wanted in note for note in result.notes] == ([True] if noted else [])
