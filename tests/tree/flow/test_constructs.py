"""What every construct does in a run, tick by tick, on a virtual clock."""

import re
from typing import Any

import pytest

from stretch_bt.errors import TreeError
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.countdown import Countdown
from stretch_bt.tree.flow import CONSTRUCTS
from stretch_bt.tree.registry import RESERVED

PERIOD_MS = 50
N = "keys: {n: {type: int, default: 0}}"
LIST = 'params: {steps: {type: "list[Length]", default: [1 mm, 2 mm]}, nothing: {type: "list[Length]", default: []}}'
KEY = "keys: {d: {type: Length, default: 9 mm}, l: 'list[Length]', e: 'list[Length]'}"

#: name -> (body, head, how it ends, ticks, the steps' trace: + begins, ! is interrupted)
RUNS: dict[str, tuple[str, str, str, int, str]] = {
    "sequence keeps what is done": (
        "sequence: [{name: a, step: {script: RS}}, {name: b, step: {script: RRS}}]",
        "",
        "SUCCESS",
        4,
        "a+ aR aS b+ bR bR bS",
    ),
    "sequence ends at the first failure": (
        "sequence: [{name: a, step: {}}, {name: b, step: {script: F}}, step]",
        "",
        "FAILURE",
        1,
        "a+ aS b+ bF",
    ),
    "a list is a sequence": (
        "force_success: [{name: a, step: {}}, {name: b, step: {}}]",
        "",
        "SUCCESS",
        1,
        "a+ aS b+ bS",
    ),
    "selector goes on after a failure": (
        "selector: [{name: a, step: {script: RF}}, {name: b, step: {}}, step]",
        "",
        "SUCCESS",
        2,
        "a+ aR aF b+ bS",
    ),
    "selector fails when all did": (
        "selector: [{name: a, step: {script: F}}, {name: b, step: {script: F}}]",
        "",
        "FAILURE",
        1,
        "a+ aF b+ bF",
    ),
    "reactive sequence asks again": (
        "reactive_sequence: [{name: a, ask: {script: SSF}}, {name: b, step: {script: R}}]",
        "",
        "FAILURE",
        3,
        "a+ aS b+ bR a+ aS bR a+ aF b!",
    ),
    "reactive selector takes the first that can": (
        "reactive_selector: [{name: a, ask: {script: FFS}}, {name: b, step: {script: R}}]",
        "",
        "SUCCESS",
        3,
        "a+ aF b+ bR a+ aF bR a+ aS b!",
    ),
    "parallel waits for all": (
        "parallel: [{name: a, step: {script: RRS}}, {name: b, step: {script: S}}]",
        "",
        "SUCCESS",
        3,
        "a+ aR b+ bS aR aS",
    ),
    "parallel ends with the first failure": (
        "parallel: [{name: a, step: {script: R}}, {name: b, step: {script: RF}}]",
        "",
        "FAILURE",
        2,
        "a+ aR b+ bR aR bF a!",
    ),
    "parallel is content with one": (
        "parallel: {policy: success_on_one, children: [{name: a, step: {script: R}}, {name: b, step: {script: RS}}]}",
        "",
        "SUCCESS",
        2,
        "a+ aR b+ bR aR bS a!",
    ),
    "parallel is content with the selected": (
        "parallel: {policy: success_on_selected, selected: [a], children: [{name: a, step: {script: RS}}, {name: b, step: {script: R}}]}",
        "",
        "SUCCESS",
        2,
        "a+ aR b+ bR aS bR b!",
    ),
    "for_each takes every item in a tick of its own": (
        "for_each: {items: $steps, as: $d, do: {show: {value: $d}}}",
        f"{LIST}\n{KEY}",
        "SUCCESS",
        2,
        "1 2",
    ),
    "for_each of nothing runs nothing": (
        "for_each: {items: $nothing, as: $d, do: {show: {value: $d}}}",
        f"{LIST}\n{KEY}",
        "SUCCESS",
        1,
        "",
    ),
    "for_each takes a zero for an item": (
        "sequence: [many: {some: $l, none: $e}, for_each: {items: $l, as: $d, do: {show: {value: $d}}}]",
        KEY,
        "SUCCESS",
        3,
        "1 0 3",
    ),
    "for_each of a list that a node found empty": (
        "sequence: [many: {some: $l, none: $e}, for_each: {items: $e, as: $d, do: {show: {value: $d}}}, show: {value: $d}]",
        KEY,
        "SUCCESS",
        1,
        "9",
    ),
    "for_each ends at the first failure": (
        "for_each: {items: [1 mm, 2 mm, 3 mm], as: $d, do: [show: {value: $d}, {name: a, step: {script: SF}}]}",
        KEY,
        "FAILURE",
        2,
        "1 a+ aS 2 a+ aF",
    ),
    "until asks after each pass": (
        "until: {that: n >= 2, max: 9, do: [{name: a, step: {}}, set: {n: n + 1}]}",
        N,
        "SUCCESS",
        2,
        "a+ aS a+ aS",
    ),
    "until fails when its passes are over": (
        "until: {that: n > 9, max: 3, do: [{name: a, step: {}}]}",
        N,
        "FAILURE",
        3,
        "a+ aS a+ aS a+ aS",
    ),
    "until fails when a pass does": (
        "until: {that: n > 9, max: 3, do: {name: a, step: {script: SF}}}",
        N,
        "FAILURE",
        2,
        "a+ aS a+ aF",
    ),
    "until waits for a pass that takes time": (
        "until: {that: n == 0, max: 3, do: {name: a, step: {script: RRS}}}",
        N,
        "SUCCESS",
        3,
        "a+ aR aR aS",
    ),
    "repeat counts the passes": ("repeat: {times: 3, do: {name: a, step: {}}}", "", "SUCCESS", 3, "a+ aS a+ aS a+ aS"),
    "repeat ends at the first failure": (
        "repeat: {times: 3, do: {name: a, step: {script: SF}}}",
        "",
        "FAILURE",
        2,
        "a+ aS a+ aF",
    ),
    "retry counts all attempts": (
        "retry: {attempts: 3, do: {name: a, step: {script: F}}}",
        "",
        "FAILURE",
        3,
        "a+ aF a+ aF a+ aF",
    ),
    "retry ends at the first success": (
        "retry: {attempts: 3, do: {name: a, step: {script: FS}}}",
        "",
        "SUCCESS",
        2,
        "a+ aF a+ aS",
    ),
    "retry beside a node": (
        "sequence: [{name: a, retry: 3, step: {script: FFS}}]",
        "",
        "SUCCESS",
        3,
        "a+ aF a+ aF a+ aS",
    ),
    "timeout interrupts what is late": (
        "timeout: {after: 100 ms, do: {name: a, step: {script: R}}}",
        "",
        "FAILURE",
        3,
        "a+ aR aR a!",
    ),
    "timeout lets pass what is in time": (
        "timeout: {after: 100 ms, do: {name: a, step: {script: RS}}}",
        "",
        "SUCCESS",
        2,
        "a+ aR aS",
    ),
    "a success that comes late is none": (
        "timeout: {after: 100 ms, do: {name: a, step: {script: RRS}}}",
        "",
        "FAILURE",
        3,
        "a+ aR aR a!",
    ),
    "timeout begins anew with each start": (
        "repeat: {times: 3, do: {name: a, timeout: 100 ms, step: {script: RSRSRS}}}",
        "",
        "SUCCESS",
        6,
        "a+ aR aS a+ aR aS a+ aR aS",
    ),
    "timeout inside retry is for each attempt": (
        "sequence: [{name: a, timeout: 100 ms, retry: 2, step: {script: RRRS}}]",
        "",
        "SUCCESS",
        5,
        "a+ aR aR a! a+ aR aS",
    ),
    "a guard is asked on every tick and interrupts": (
        "guard: task.ticks < 3\nsequence: [{name: a, step: {script: R}}]",
        "",
        "FAILURE",
        3,
        "a+ aR aR a!",
    ),
    "a guard that does not hold starts nothing": (
        "guard: task.ticks < 1\nsequence: [{name: a, step: {}}]",
        "",
        "FAILURE",
        1,
        "",
    ),
    "while is a guard beside a node": (
        "sequence: [{name: a, guard: task.ticks < 3, step: {script: R}}]",
        "",
        "FAILURE",
        3,
        "a+ aR aR a!",
    ),
    "guard around a body": (
        "guard: {that: task.ticks < 3, do: {name: a, step: {script: R}}}",
        "",
        "FAILURE",
        3,
        "a+ aR aR a!",
    ),
    "all of several guards must hold": (
        "guard: [task.ticks < 9, task.ticks < 2]\nsequence: [{name: a, step: {script: R}}]",
        "",
        "FAILURE",
        2,
        "a+ aR a!",
    ),
    "check asks once": (
        "sequence: [check: task.ticks == 1, {name: a, step: {script: RS}}]",
        "",
        "SUCCESS",
        2,
        "a+ aR aS",
    ),
    "skip_if passes a node over": (
        "sequence: [{name: a, skip_if: task.ticks == 1, step: {}}, {name: b, step: {}}]",
        "",
        "SUCCESS",
        1,
        "b+ bS",
    ),
    "skip_if is asked before the start alone": (
        "sequence: [{name: a, skip_if: task.ticks == 2, step: {script: RRS}}]",
        "",
        "SUCCESS",
        3,
        "a+ aR aR aS",
    ),
    "invert": (
        "sequence: [invert: {name: a, step: {script: RF}}, invert: {name: b, step: {}}]",
        "",
        "FAILURE",
        2,
        "a+ aR aF b+ bS",
    ),
    "force_success": (
        "sequence: [force_success: {name: a, step: {script: RF}}, force_success: {name: b, step: {}}]",
        "",
        "SUCCESS",
        2,
        "a+ aR aF b+ bS",
    ),
    "force_failure": (
        "selector: [force_failure: {name: a, step: {}}, force_failure: {name: b, step: {script: F}}]",
        "",
        "FAILURE",
        1,
        "a+ aS b+ bF",
    ),
    "fail": ("selector: [fail: on purpose, {name: a, step: {}}]", "", "SUCCESS", 1, "a+ aS"),
    "set reads all before it writes any": (
        "sequence: [set: {d: 1 mm, g: 2 mm}, set: {d: g, g: d}, show: {value: $d}, show: {value: $g}]",
        "keys: {d: Length, g: Length}",
        "SUCCESS",
        1,
        "2 1",
    ),
    "log changes nothing": ("sequence: [{name: a, log: felt it, step: {script: RS}}]", "", "SUCCESS", 2, "a+ aR aS"),
    "words beside a node and among its ports do the same": (
        "sequence: [{name: a, step: {script: FS}, retry: 2}, {name: b, retry: 2, step: {script: FS}}]",
        "",
        "SUCCESS",
        3,
        "a+ aF a+ aS b+ bF b+ bS",
    ),
    "finally runs after a success": (
        "sequence: [{name: a, step: {}}]\nfinally: [{name: z, step: {}}]",
        "",
        "SUCCESS",
        1,
        "a+ aS z+ zS",
    ),
    "finally runs after a failure": (
        "sequence: [{name: a, step: {script: F}}]\nfinally: [{name: z, step: {}}]",
        "",
        "FAILURE",
        1,
        "a+ aF z+ zS",
    ),
}


@pytest.mark.parametrize("name", RUNS)
def test_a_construct_does_what_it_says(task: Any, name: str) -> None:
    body, head, status, ticks, did = RUNS[name]
    outcome = task.run(body, head)
    assert (outcome.status, task.did) == (status, did), outcome.reason
    assert (outcome.ticks == ticks) or "finally" in name


def test_every_construct_and_word_is_run() -> None:
    used = " ".join(f"{body}" for body, *_ in RUNS.values())
    missing = {word for word in {*CONSTRUCTS, *RESERVED} - {"doc"} if f"{word}:" not in used}
    assert missing == set()


#: body -> the reason of the failure
REASONS = {
    "sequence: [fail: the object is gone]": "the object is gone",
    "sequence: [check: n > 3]": "'n > 3' does not hold: n = 0",
    "sequence: [check: d > 3 mm]": "'d > 3 mm' does not hold: d = 1.5 mm",
    "guard: task.ticks < 2\nsequence: [step: {script: R}]": "'task.ticks < 2' does not hold: task.ticks = 2",
    "timeout: {after: 100 ms, do: {step: {script: R}}}": "out of time while main/timeout/step was running",
    "retry: {attempts: 2, do: {step: {script: F}}}": "2 attempts failed",
    "until: {that: n > 3, max: 2, do: {step: {}}}": "still does not hold after 2 passes",
    "sequence: [set: {xs: [1 mm, 2 mm]}, check: sum(xs) > 1 m]": "does not hold: xs = [1 mm, 2 mm]",
    "for_each: {items: [1, 2, 3], as: $i, do: {check: i < 2}}": "pass 2 failed at main/check: 'i < 2' does not hold: i = 2",
    "repeat: {times: 3, do: [set: {n: n + 1}, check: n < 3]}": "pass 3 failed at main/repeat/check: 'n < 3'",
}


def logged(task: Any) -> list[str]:
    return [text for _, path, status, text in task.events.statuses if path.endswith(":log") and status == "SUCCESS"]


def test_what_ends_in_the_tick_in_which_it_starts_is_told_in_each_pass(task: Any) -> None:
    """In the second pass a `set` or `check` was once reported no more, and its `log` was lost."""
    body = """
for_each:
  items: [1, 2, 3]
  as: $i
  do:
    - {set: {n: n + i}, log: n is $n}
    - {force_success: {check: {that: n > 2, else: n is $n}}, log: asked}
"""
    outcome = task.run(body, "keys: {n: {type: int, default: 0}}")
    assert outcome.status == "SUCCESS"
    assert logged(task) == ["n is 1", "asked", "n is 3", "asked", "n is 6", "asked"]


def test_a_condition_that_is_asked_at_each_tick_is_told_once(task: Any) -> None:
    body = "repeat: {times: 2, do: {reactive_sequence: [{check: n == 0, log: asked}, step: {script: RRS}]}}"
    task.run(body, "keys: {n: {type: int, default: 0}}")
    assert logged(task) == ["asked", "asked"]


@pytest.mark.parametrize("body", REASONS)
def test_a_failure_says_why_with_the_values_it_saw(task: Any, body: str) -> None:
    outcome = task.run(body, "keys: {n: {type: int, default: 0}, d: {type: Length, default: 1.5 mm}}")
    assert outcome.status == "FAILURE"
    assert REASONS[body] in outcome.reason


@pytest.mark.parametrize(
    ("loop", "status", "reason"),
    [
        ("repeat: {times: n + COUNT, do: {name: a, step: {}}}", "SUCCESS", ""),
        ("retry: {attempts: n + COUNT, do: {name: a, step: {}}}", "FAILURE", "attempts is 0"),
        ("until: {that: n == 0, max: n + COUNT, do: {name: a, step: {}}}", "FAILURE", "max is 0"),
    ],
)
def test_a_loop_of_no_passes_runs_none_and_one_of_less_is_an_error(
    task: Any, loop: str, status: str, reason: str
) -> None:
    outcome = task.run(loop.replace("COUNT", "0"), N)
    assert (outcome.status, outcome.ticks, task.did) == (status, 1, "")
    assert reason in outcome.reason
    outcome = task.run(loop.replace("n + COUNT", "n - 7"), N)
    assert (outcome.status, task.did) == ("ERROR", "")
    assert "is -7; a loop runs 0 times or more" in outcome.reason


@pytest.mark.parametrize(
    ("loop", "status", "passes"),
    [
        ("repeat: {times: n, do: {set: {n: n + 1}}}", "SUCCESS", 2),
        ("retry: {attempts: n, do: [set: {n: n + 1}, fail: no]}", "FAILURE", 2),
        ("until: {that: n > 99, max: n, do: {set: {n: n + 1}}}", "FAILURE", 2),
        ("repeat: {times: 2, do: {repeat: {times: n, do: {set: {n: n + 1}}}}}", "SUCCESS", 2 + 4),
    ],
)
def test_a_count_is_worked_out_once_as_the_loop_begins(task: Any, loop: str, status: str, passes: int) -> None:
    outcome = task.run(f"sequence: [{loop}]", "keys: {n: {default: 2}}")
    assert (outcome.status, len(task.events.writes)) == (status, passes), outcome.reason


@pytest.mark.parametrize("before", [0, 1, 7, 33])
def test_times_on_the_grid_of_ticks_are_over_on_it(task: Any, before: int) -> None:
    """Each sum of ticks, whatever its rounding: a timeout interrupts, and a wait ends, at the tick that it names."""
    late = {}
    for ticks in range(1, 121):
        wait = f"wait: {{duration: {PERIOD_MS * before} ms}}"
        timeout = f"timeout: {{after: {PERIOD_MS * ticks} ms, do: {{step: {{script: R}}}}}}"
        outcome = task.run(f"sequence: [{wait}, {timeout}]")
        late[ticks] = outcome.ticks - (before + ticks + 1)
    assert {ticks: by for ticks, by in late.items() if by} == {}


def test_a_tick_that_comes_a_little_late_is_not_a_tick_late() -> None:
    """The clock of a machine wakes up to some milliseconds late, each time by another time."""
    context = RunContext()
    context.period = 0.05
    context.start = context.now = 1.004
    time = Countdown(context, 0.5)
    for slot, late in [(9, 0.030), (10, 0.0001)]:
        context.now = 1.0 + slot * context.period + late
        assert time.over is (slot == 10)


def test_the_text_of_log_reaches_the_log_with_the_end_of_the_node(task: Any) -> None:
    task.run("sequence: [{name: a, log: felt the top, step: {script: RS}}]")
    assert [(tick, status) for tick, _, status, reason in task.events.statuses if reason == "felt the top"] == [
        (2, "SUCCESS")
    ]


#: body, with a log beside what fails -> the reason of the failure
LOGGED = {
    "{log: late, check: {that: n > 3, else: gone}}": "main/check: gone",
    "until: {that: n > 3, max: 3, do: {log: late, check: {that: n > 3, else: gone}}}": "main/until: pass 1 failed at main/until/check: gone",
    "{log: late, repeat: {times: 3, do: {check: {that: n > 3, else: gone}}}}": "main/repeat: pass 1 failed at main/repeat/check: gone",
    "{log: late, guard: {that: n > 3, name: g}, step: {script: R}}": "main/g: 'n > 3' does not hold: n = 0",
    "{log: late, skip_if: n > 3, timeout: 100 ms, step: {script: R}}": "main/step:timeout: out of time while main/step was running",
    "{log: late, sequence: [step: {}, fail: gone]}": "main/fail: gone",
    "{log: late, step: {script: F}}": "main/step: failed",
    "run: sub": "main/sub/fail: gone",
}


@pytest.mark.parametrize("body", LOGGED)
def test_a_log_beside_what_fails_leaves_its_reason(task: Any, body: str) -> None:
    trees = "sub:\n  log: late\n  fail: gone" if "sub" in body else ""
    outcome = task.run(f"sequence:\n  - {body}", N, trees)
    assert (outcome.status, outcome.reason) == ("FAILURE", LOGGED[body])
    ends = [text for _, path, status, text in task.events.statuses if path.endswith(":log") and status == "FAILURE"]
    assert ends == ["late"]


def test_a_division_by_zero_in_a_run_is_an_error_with_the_place_and_no_traceback(task: Any) -> None:
    outcome = task.run("sequence: [check: 1 / n > 2]", N)
    assert outcome.status == "ERROR"
    assert "main/check" in outcome.reason


def test_time_is_that_of_the_run(task: Any) -> None:
    outcome = task.run("sequence: [wait: {duration: 0.5 s}, set: {t: task.time}]", "keys: {t: Time}")
    assert outcome.status == "SUCCESS"
    assert task.events.writes[-1] == ("main/t", pytest.approx(0.5))


def test_readings_are_asked_when_they_are_needed(task: Any) -> None:
    context = RunContext()
    values = iter([1.0, 2.0, 7.0])
    context.mocked_readings["arm.force"] = lambda: next(values)
    outcome = task.run(
        "guard: arm.force < 5 N\nsequence: [{name: a, step: {script: R}}]", "devices: {arm: Arm}", context=context
    )
    assert (outcome.status, task.did) == ("FAILURE", "a+ aR aR a!")


SUBTREE = """
sub:
  in: {depth: Length, often: {type: int, default: 2}}
  out: {seen: Length, count: int}
  keys: {half: {type: Length, default: 0 mm}, total: {type: int, default: 0}}
  sequence:
    - repeat: {times: $often, do: {set: {total: total + 1, half: half + depth / 2}}}
    - set: {seen: half, count: total}
"""


def test_a_called_tree_has_fresh_keys_at_each_start(task: Any) -> None:
    body = """
    out: {first: Length, second: Length, count: int}
    sequence:
      - repeat: {times: 2, do: {sub: {depth: 4 mm, seen: $first}}}
      - sub: {depth: 2 mm, often: 3, seen: $second, count: $count}
    """
    outcome = task.run(body, trees=SUBTREE)
    assert outcome.status == "SUCCESS", outcome.reason
    assert task.output("first") == (pytest.approx(0.004), None)
    assert task.output("second") == (pytest.approx(0.003), None)
    assert task.output("count")[0] == 3


def test_an_input_is_the_callers_key_and_an_expression_is_worked_out_at_each_read(task: Any) -> None:
    body = """
    keys: {d: Length}
    sequence:
      - set: {d: 1 mm}
      - parallel:
          - sequence: [{name: a, step: {script: RS}}, set: {d: 5 mm}]
          - watch: {same: $d, twice: $d * 2, fixed: 3 mm}
    """
    trees = """
    watch:
      in: {same: Length, twice: Length, fixed: Length}
      sequence:
        - show: {value: $same}
        - name: b
          step: {script: RRS}
        - show: {value: $same}
        - show: {value: $twice}
        - show: {value: $fixed}
    """
    outcome = task.run(body, trees=trees)
    assert outcome.status == "SUCCESS", outcome.reason
    assert task.did == "a+ aR 1 b+ bR aS bR bS 5 10 3"


def test_an_output_is_seen_by_the_caller_at_once_and_may_be_what_was_given(task: Any) -> None:
    body = "out: {d: Length}\nsequence: [set: {d: 1 mm}, deeper: {from: $d, to: $d}, deeper: {from: $d, to: $d}]"
    outcome = task.run(
        body, trees="deeper: {in: {from: Length}, out: {to: Length}, sequence: [set: {to: from + 2 mm}]}"
    )
    assert outcome.status == "SUCCESS"
    assert task.output("d")[0] == pytest.approx(0.005)


def test_a_standard_deviation_goes_with_its_value_and_can_be_read_and_kept(task: Any) -> None:
    body = """
    out: {a: Length, b: Length, c: Length, s: Length}
    sequence:
      - measure: {length: $a, length_sd: $s}
      - set: {b: a * 2, b_sd: a_sd * 2, c: a}
      - show: {value: $a_sd}
    """
    outcome = task.run(body)
    assert outcome.status == "SUCCESS", outcome.reason
    assert task.output("a") == (pytest.approx(0.007), pytest.approx(0.001))
    assert task.output("b") == (pytest.approx(0.014), pytest.approx(0.002))
    assert task.output("c") == (pytest.approx(0.007), pytest.approx(0.001))
    assert task.output("s")[0] == pytest.approx(0.001)
    assert task.did == "1"


def test_a_standard_deviation_that_is_not_there_says_so(task: Any) -> None:
    outcome = task.run("keys: {a: Length}\nsequence: [set: {a: 1 mm}, check: a_sd < 1 mm]")
    assert outcome.status == "ERROR"
    assert "no standard deviation" in outcome.reason


def test_finally_of_called_trees_runs_once_innermost_first_whatever_the_body_ended_with(task: Any) -> None:
    trees = """
    outer: {sequence: [inner, {name: b, step: {script: F}}], finally: [{name: y, step: {script: RS}}]}
    inner: {sequence: [{name: a, step: {}}], finally: [{name: x, step: {}}]}
    """
    outcome = task.run("selector: [outer, {name: c, step: {}}]\nfinally: [{name: z, step: {}}]", trees=trees)
    assert outcome.status == "SUCCESS", outcome.reason
    assert task.did == "a+ aS x+ xS b+ bF y+ yR yS c+ cS z+ zS"


def test_a_failing_finally_of_a_called_tree_fails_the_call(task: Any) -> None:
    trees = "sub: {sequence: [{name: a, step: {}}], finally: [{name: z, step: {script: F}}]}"
    outcome = task.run("sequence: [sub]", trees=trees)
    assert outcome.status == "FAILURE"
    assert "finally failed" in outcome.reason


def test_a_value_out_of_the_bounds_of_its_port_fails_the_node(task: Any) -> None:
    """What is not known at load is held against the bounds of the port in the run."""
    body = "keys: {s: Length}\nsequence: [set: {s: task.ticks * 1 m}, predict_force: {radius: 30 mm, stretch: $s, depth: 1 mm, force: $f}]"
    outcome = task.run(body, "keys: {f: Force}")
    assert outcome.status == "FAILURE"
    assert "main/predict_force: stretch: 1000 mm is outside 0 mm to 80 mm" in outcome.reason


#: values to set, and the message
NO_NUMBER = [
    ("{y: y * 10}", r"1e\+308 \* 10 is no finite number"),
    ("{y: y + y}", r"1e\+308 \+ 1e\+308 is no finite number"),
    ("{y: 1 / z}", r"1 / 0.0 is no finite number"),
    ("{y: sqrt(z - 1)}", r"sqrt\(-1.0\) is no finite number"),
    ("{z: 1, z_sd: z - 1}", r"the standard deviation of \$z is -1; it is not below 0"),
]


@pytest.mark.parametrize(("given", "told"), NO_NUMBER)
def test_nothing_sets_a_number_that_is_none(task: Any, given: str, told: str) -> None:
    head = "keys: {y: {type: float, default: 1e308}, z: {type: float, default: 0}}"
    outcome = task.run(f"set: {given}", head)
    assert outcome.status == "ERROR"
    assert re.search(told, outcome.reason)


def test_a_whole_number_does_not_grow_without_end(task: Any) -> None:
    outcome = task.run("repeat: {times: 60, do: {set: {n: n * n}}}", "keys: {n: {type: int, default: 10}}")
    assert "is no finite number" in outcome.reason


def test_a_word_that_a_key_lists_is_set_in_quotes_of_its_own(task: Any) -> None:
    body = (
        """keys: {mode: {type: slow | fast, default: fast}}\nsequence: [set: {mode: "'%s'"}, check: "mode == 'slow'"]"""
    )
    assert task.run(body % "slow").status == "SUCCESS"
    with pytest.raises(TreeError, match="'slwo' is str but mode takes slow"):
        task.load(body % "slwo")
