"""Outputs that are absent, errors that go along, texts with values, loops that collect."""

from dataclasses import dataclass
from typing import Any

import pytest

from stretch_bt import check
from stretch_bt.tree import registry
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.units import Length


class Perhaps(Behavior):
    """Gives a length, or none."""

    instant = True
    given: In[bool] = True
    length: Out[Length | None]

    def update(self) -> Status:
        self.length = 0.002 if self.given else None
        return Status.SUCCESS


class Sometimes(Behavior):
    """Gives a length in its first start alone, and a second one never."""

    instant = True
    length: Out[Length | None]
    never: Out[Length | None]

    def update(self) -> Status:
        if self.runs == 1:
            self.length = 0.002
        return Status.SUCCESS


class Takes(Behavior):
    """Says whether it got a length, and with which error."""

    instant = True
    length: In[Length | None] = None
    length_sd: In[Length] = 0.009
    seen: Out[str]

    def update(self) -> Status:
        self.seen = "none" if self.length is None else f"{self.length * 1e3:g} {self.length_sd * 1e3:g}"
        return Status.SUCCESS


@dataclass
class Ball:
    """A ball, and a list of what was seen of it."""

    radius: Length
    radius_sd: Length
    seen: list[Length]


class Balls(Behavior):
    """Gives a ball."""

    instant = True
    ball: Out[Ball]

    def update(self) -> Status:
        self.ball = Ball(0.003, 0.0002, [0.003])
        return Status.SUCCESS


@pytest.fixture
def nodes(task: Any) -> Any:
    for cls in (Perhaps, Sometimes, Takes, Balls):
        registry.node(cls)
    return task


#: body -> how it ends, part of the reason
ABSENT = {
    "sequence: [perhaps: {given: false, length}, check: length == none]": ("SUCCESS", ""),
    "sequence: [perhaps: {length}, check: length == none]": ("FAILURE", "'length == none' does not hold"),
    "sequence: [perhaps: {length}, check: length != none and length > 1 mm]": ("SUCCESS", ""),
    "sequence: [perhaps: {given: false, length}, set: {other: length}, check: other == none]": ("SUCCESS", ""),
    "sequence: [perhaps: {length}, set: {length: none}, check: length == none]": ("SUCCESS", ""),
    "sequence: [perhaps: {given: false, length}, check: length > 1 mm]": (
        "FAILURE",
        "$main/length is none: main/perhaps",
    ),
    "sequence: [perhaps: {given: false, length}, show: {value: $length}]": ("FAILURE", "$main/length is none"),
    "sequence: [perhaps: {given: false, length}, takes: {length, seen}, check: seen == 'none']": ("SUCCESS", ""),
    "sequence: [perhaps: {given: false, length}, fail: it is $length long]": ("FAILURE", "it is none long"),
    "sequence: [perhaps: {length}, fail: it is $length long]": ("FAILURE", "it is 2 mm long"),
    "sequence: [perhaps: {length}, check: {that: length > 3 mm, else: '$length is less than $least'}]": (
        "FAILURE",
        "2 mm is less than 3 mm",
    ),
    "sequence: [perhaps: {length}, check: {that: length > 3 mm, else: costs $5}]": ("FAILURE", "costs $5"),
}


@pytest.mark.parametrize("body", ABSENT)
def test_what_may_be_absent(nodes: Any, body: str) -> None:
    status, reason = ABSENT[body]
    outcome = nodes.run(body, "params: {least: {default: 3 mm}}")
    assert (outcome.status, reason in outcome.reason) == (status, True), outcome.reason


@pytest.mark.parametrize("declared", ["", "keys: {length: {default: 3 mm}, never: {default: 3 mm}}"])
def test_an_optional_output_that_a_start_does_not_assign_is_none(nodes: Any, declared: str) -> None:
    body = """
        out: [seen, never]
        repeat:
          times: 2
          do: [sometimes: {length, never}, set: {seen: length}]
        """
    assert nodes.run(body, declared).status == "SUCCESS"
    assert [value for key, value in nodes.events.writes if key == "main/seen"] == [0.002, None]
    assert [value for key, value in nodes.events.writes if key == "main/never"] == [None, None]


def test_an_absent_output_of_a_task_is_absent(nodes: Any) -> None:
    nodes.run("out: [length]\nsequence: [perhaps: {given: false, length}]")
    assert not nodes.output("length")[0]


#: the source of `takes.length` -> the value and the deviation that it saw, mm
ERRORS = {
    "$a": "7 1",
    "a": "7 1",
    "a * 2": "14 9",
    "5 mm": "5 9",
    "$plain": "4 9",
    "$known": "6 0.5",
    "$b": "7 1",
    "$twice": "14 3",
    "mean(lengths)": "7 0.57735",
    "at(lengths, 1)": "7 1",
    "$lengths.1": "7 1",
    "lengths.2": "7 1",
    "$plains.0": "4 9",
    "$ball.radius": "3 0.2",
    "$balls.1.radius": "3 0.2",
    "$balls.0.seen.0": "3 9",
}


@pytest.mark.parametrize("wire", ERRORS)
def test_an_error_goes_with_its_value(nodes: Any, wire: str) -> None:
    body = f"""
    out: [seen]
    sequence:
      - repeat:
          times: 3
          do: [measure: {{length: $a}}, balls: {{ball}}]
          collect: {{lengths: $a, balls: $ball}}
      - set: {{plain: 4 mm, plains: [4 mm], b: a, twice: a * 2, twice_sd: 3 mm}}
      - takes: {{length: "{wire}", seen}}
      - check: plain + b + twice > 0 mm and len(lengths) > 0 and known > 0 mm
      - check: len(balls) > 0 and len(plains) > 0 and ball.radius > 0 mm
    """
    head = "params: {known: {default: 6 mm}, known_sd: {default: 0.5 mm}}"
    outcome = nodes.run(body, head)
    assert outcome.status == "SUCCESS", outcome.reason
    assert nodes.output("seen")[0] == ERRORS[wire]


def test_an_error_goes_through_the_border_of_a_tree(nodes: Any) -> None:
    trees = "sub: {in: [length], out: [seen], sequence: [takes: {length, seen}]}"
    nodes.run("out: [seen]\nsequence: [measure: {length: $a}, sub: {length: $a, seen}]", trees=trees)
    assert nodes.output("seen")[0] == "7 1"


def test_a_loop_counts_collects_and_keeps_keys_of_its_own(nodes: Any) -> None:
    body = """
    out: [lengths, numbers]
    sequence:
      - for_each:
          items: [1 mm, 2 mm, 3 mm]
          as: $each
          index: $i
          collect: {lengths: $kept, numbers: $number}
          keys: {passes: {default: 0}}
          do:
            - set: {passes: passes + 1, number: i}
            - {set: {kept: each * 2}, skip_if: each == 2 mm}
            - check: passes == i + 1
    """
    outcome = nodes.run(body)
    assert outcome.status == "SUCCESS", outcome.reason
    assert list(nodes.output("lengths")[0]) == [pytest.approx(0.002), pytest.approx(0.006)]
    assert list(nodes.output("numbers")[0]) == [0, 2]


def test_the_condition_of_a_loop_may_read_what_it_collects(nodes: Any) -> None:
    body = "out: [all_]\nsequence: [until: {that: len(all_) >= 3, max: 9, do: {measure: {length: $a}}, collect: {all_: $a}}]"
    assert nodes.run(body).status == "SUCCESS"
    assert len(nodes.output("all_")[0]) == 3


def test_a_tree_reads_and_writes_a_key_of_its_caller(nodes: Any) -> None:
    trees = """
    sub: {inout: {count: {default: 5}}, sequence: [set: {count: count + 1}]}
    alone: {sequence: [sub]}
    """
    body = "out: [count]\nsequence: [sub: {count}, sub: {count}, alone, check: count == 7]"
    outcome = nodes.run(body, trees=trees)
    assert outcome.status == "SUCCESS", outcome.reason
    assert nodes.output("count")[0] == 7


#: a body that reads keys which are absent by their default -> how it ends, part of the reason
BY_DEFAULT = {
    "check: x > 1 mm": ("FAILURE", "$main/x is none, as it is by default"),
    "check: x == none": ("SUCCESS", ""),
    "selector: [check: x > 1 mm, check: x == none]": ("SUCCESS", ""),
    "for_each: {items: $xs, as: $i, do: [check: i > 0]}": ("FAILURE", "$main/xs is none"),
    "set: {y: 2 * x}": ("FAILURE", "$main/x is none"),
    "selector: [set: {y: 2 * x}, set: {y: 1 mm}]": ("SUCCESS", ""),
    "wait: {duration: 1 s * (x / 1 mm)}": ("FAILURE", "$main/x is none"),
}


@pytest.mark.parametrize("body", BY_DEFAULT)
def test_a_key_that_is_absent_by_default_fails_what_needs_it(run: Any, body: str) -> None:
    """It was a TypeError, and `check` held that a `set` that works something out of it cannot fail."""
    status, reason = BY_DEFAULT[body]
    keys = "{x: {type: Length, default: none}, xs: {type: 'list[int]', default: none}, y: {default: 0 mm}}"
    outcome = run(f"format: stretch-tree/1\ntrees: {{main: {{keys: {keys}, sequence: [{body}, check: y >= 0 mm]}}}}\n")
    assert (outcome.status, reason in outcome.reason) == (status, True), outcome.reason


@pytest.mark.parametrize(
    ("first", "worked_out"),
    [
        ("lacks: {d: $d}", "d + 1 mm"),
        ("sequence: [lacks: {d: $d}, set: {e: d}]", "e + 1 mm"),
        ("set: {e: 1 mm}", "at(xs, 1)"),
        ("set: {e: 1 mm}", "mean(xs)"),
        ("set: {e: 1 mm}", "xs.0 + 1 mm"),
    ],
)
def test_a_set_that_may_have_no_value_may_fail(run: Any, first: str, worked_out: str) -> None:
    """`check` held that it cannot, and refused what comes after it in a selector."""
    outcome = run(f"""\
format: stretch-tree/1
trees:
  lacks:
    out: {{d: {{type: Length, default: none}}}}
    check: 1 < 2
  main:
    keys: {{e: {{type: Length, default: 1 mm}}, xs: {{type: "list[Length]", default: []}}}}
    out: {{y: Length}}
    sequence:
      - {first}
      - selector:
          - set: {{y: "{worked_out}", y_sd: 1 mm}}
          - set: {{y: 2 mm, y_sd: 1 mm}}
      - check: y == 2 mm
      - lacks: {{}}
      - set: {{e: 2 mm}}
      - check: e > 0 mm
""")
    assert outcome.status == "SUCCESS", outcome.reason


def test_the_default_of_an_out_reaches_the_key_of_a_call_that_succeeds(run: Any) -> None:
    """`check` counted on it, and the run ended with an error. What the body reads of the caller's key stays until it writes."""
    outcome = run("""\
format: stretch-tree/1
trees:
  keeps:
    in: {a: Length, ok: bool}
    out: {d: {type: Length, default: 3 mm}}
    sequence: [check: a == 8 mm, check: d == 3 mm, check: ok]
  writes:
    out: {d: {type: Length, default: 3 mm}}
    set: {d: 5 mm}
  collects:
    out: {d: {type: Length, default: 3 mm}}
    for_each:
      items: [1, 2, 3]
      as: $n
      do: [{set: {d: n * 2 mm}, skip_if: n == 3}]
      collect: {each: $d}
  main:
    keys: {d: {default: 8 mm}}
    sequence:
      - force_success: {keeps: {a: $d, ok: false, d: $d}}
      - check: d == 8 mm
      - keeps: {a: $d, ok: true, d: $d}
      - check: d == 3 mm
      - writes: {d: $d}
      - check: d == 5 mm
      - collects: {d: $d}
      - check: d == 4 mm
""")
    assert outcome.status == "SUCCESS", outcome.reason


@pytest.mark.parametrize("declared", ["", "keys: {f: {type: Length, default: none}}", "keys: {f: {default: 2 mm}}"])
def test_an_inout_whose_default_is_none_may_be_read_before_anything_wrote_it(run: Any, declared: str) -> None:
    """It counted as one without a default."""
    outcome = run(f"""\
format: stretch-tree/1
trees:
  over:
    inout: {{q: {{type: Length, default: none}}}}
    sequence:
      - check: q == none or q == 2 mm
      - set: {{q: 1 mm}}
  main:
    {declared}
    sequence:
      - over: {{q: $f}}
      - check: f == 1 mm
""")
    assert outcome.status == "SUCCESS", outcome.reason


#: bodies of keys that are `none` alone, or were until something else wrote them
NEVER_THERE = [
    "sequence: [set: {a: none}, check: a == none]",
    "sequence: [set: {a: none}, set: {b: a}, check: b == none, fail: b is $b]",
    "sequence: [lacks: {d: $k}, check: k == none, set: {k: 3 mm}, check: k == 3 mm]",
]


@pytest.mark.parametrize("body", NEVER_THERE)
def test_a_key_that_is_never_there_may_be_asked_about(run: Any, body: str) -> None:
    """`check` found nothing, and the run was refused: this place was not understood."""
    lacks = "lacks: {out: {d: {default: none}}, check: 1 < 2}" if "lacks" in body else ""
    outcome = run(f"format: stretch-tree/1\ntrees:\n  main: {{{body}}}\n  {lacks}\n")
    assert outcome.reason in ("", "main/fail: b is none"), outcome.reason


def test_the_word_none_is_no_condition(tmp_path: Any) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text("format: stretch-tree/1\ntrees: {main: {sequence: [check: none]}}\n")
    assert [found.code for found in check(path)] == ["type-mismatch"]


def test_a_key_that_is_none_alone_is_not_held_for_unread(tmp_path: Any) -> None:
    path = tmp_path / "tree.yaml"
    head = "format: stretch-tree/1\ndevices: {arm: Arm, gripper: Gripper, camera: DepthCamera}\n"
    path.write_text(f"{head}trees: {{main: {{sequence: [set: {{k: none}}, approach: {{max_travel: $k}}]}}}}\n")
    assert check(path) == []


def test_a_param_that_may_be_none_can_be_set_to_it(run: Any) -> None:
    text = "format: stretch-tree/1\nparams: {p: {type: Length, default: none}}\ntrees: {main: {sequence: [check: p == none]}}\n"
    assert [run(text, params={"p": value}).status for value in (None, "none", 0.003)] == [
        "SUCCESS",
        "SUCCESS",
        "FAILURE",
    ]


#: bodies that leave bounds: the keys that main declares, the body, the message
LEAVING = [
    ("{x: {default: 2 mm, max: 5 mm}}", "repeat: {times: 5, do: {set: {x: x + 1 mm}}}", "$x: 6 mm is above 5 mm"),
    ("{i: {type: int, max: 2}}", "for_each: {items: [1, 3], as: $i, do: [check: i > 0]}", "$i: 3 is above 2"),
    ("{length: {type: Length, min: 5 mm}}", "perhaps: {length: $length}", "$length: 2 mm is below 5 mm"),
    (
        "{xs: {type: 'list[int]', max: 1}}",
        "for_each: {items: [1, 2], as: $n, do: [set: {i: n}], collect: {xs: $i}}",
        "$xs: 2 is above 1",
    ),
    ("{e: {default: 4 mm}}", "sequence: [set: {e: 2 * e}, into: {d: $e}]", "d: 8 mm is above 5 mm"),
    (
        "{xs: {type: 'list[int]', max: 1}, i: {default: 0}}",
        "selector: [repeat: {times: 2, do: [set: {i: i + 1}], collect: {xs: $i}}, fail: as it should]",
        "as it should",
    ),
    ("{e: {default: 4 mm}}", "sequence: [out_of: {e: $e, y: $f}, check: f > 0 mm]", "$y: 8 mm is above 5 mm"),
    ("{x: {default: 4.5 mm}}", "grow: {x: $x}", "$x: 5.5 mm is above 5 mm"),
    ("{x: {default: 8 mm}}", "sequence: [halve: {x: $x}, halve: {x: $x}]", "$x: 8 mm is above 5 mm"),
]
BOUNDED = {
    "grow": "grow: {inout: {x: {type: Length, max: 5 mm}}, set: {x: x + 1 mm}}",
    "halve": "halve: {inout: {x: {type: Length, max: 5 mm}}, set: {x: x / 2}}",
    "into": "into: {in: {d: {type: Length, max: 5 mm}}, check: d > 1 mm}",
    "out_of": "out_of: {in: {e: Length}, out: {y: {type: Length, max: 5 mm}}, set: {y: 2 * e}}",
}


@pytest.mark.parametrize(("keys", "body", "said"), LEAVING)
def test_the_bounds_of_a_name_hold_in_the_run(nodes: Any, keys: str, body: str, said: str) -> None:
    """They held for literals alone."""
    trees = "\n".join(text for name, text in BOUNDED.items() if f"{name}:" in body)
    outcome = nodes.run(f"keys: {keys}\n{body}", trees=trees)
    assert (outcome.status, said in outcome.reason) == ("FAILURE", True), outcome.reason


def test_an_inout_within_its_bounds_is_the_key_of_the_caller(run: Any) -> None:
    outcome = run("""\
format: stretch-tree/1
trees:
  grow: {inout: {x: {type: Length, max: 5 mm}}, sequence: [set: {y: x, z: x_sd}, set: {x: y + 1 mm, x_sd: z}]}
  main:
    out: [x]
    sequence: [set: {x: 2 mm, x_sd: 0.1 mm}, grow: {x: $x}, grow: {x: $x}]
""")
    assert outcome.status == "SUCCESS", outcome.reason
    assert outcome.outputs["x"] == {"value": pytest.approx(4.0), "unit": "mm", "sd": pytest.approx(0.1)}
