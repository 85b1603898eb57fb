"""What mocks do to a run of an unedited tree: time, outputs, statuses, conditions, readings and expectations."""

from typing import Any

import pytest

from stretch_bt.run.mock_node import pattern_fits

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
      - press: {depth: 1 mm}
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


def test_a_mock_takes_its_time_on_the_clock_of_the_run(mocked: Any) -> None:
    quick = mocked(f"{LOOK}, outputs: {{height: 3 mm}}")
    slow = mocked(f"{LOOK}, outputs: {{height: 3 mm}}, after: 0.5 s")
    assert slow.task_seconds - quick.task_seconds == pytest.approx(1.5)
    assert slow.wall_seconds < 5


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
    assert "gives no 'stretch'" in result.reason


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
