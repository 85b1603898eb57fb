"""The check of the data flow against every outcome: what it accepts never reads an unset key."""

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

from stretch_bt.errors import UnsetKey
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree import registry
from stretch_bt.tree.build import build
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.program import Program, load_program
from stretch_bt.units import Length


class Choices:
    """Answers yes or no; `runs` goes through every sequence of answers that makes a difference."""

    def __init__(self) -> None:
        self.answers: list[bool] = []
        self.asked = 0

    def __call__(self) -> bool:
        if self.asked == len(self.answers):
            self.answers.append(True)
        self.asked += 1
        return self.answers[self.asked - 1]

    def runs(self, limit: int) -> Iterator[int]:
        for number in range(limit):
            self.asked = 0
            yield number
            while self.answers and not self.answers[-1]:
                self.answers.pop()
            if not self.answers:
                return
            self.answers[-1] = False


class Chosen(Behavior):
    """Succeeds or fails, as is chosen."""

    choose: ClassVar[Choices] = Choices()
    instant: ClassVar[bool] = True

    def act(self) -> None:
        """What it does before it succeeds."""

    def update(self) -> Status:
        if not self.choose():
            return Status.FAILURE
        self.act()
        return Status.SUCCESS


class Give(Chosen):
    """Writes a key when it succeeds."""

    key: Out[Length]

    def act(self) -> None:
        self.key = 0.001


class Take(Chosen):
    """Reads a key, whatever it ends with."""

    key: In[Length]

    def update(self) -> Status:
        assert self.key == 0.001
        return super().update()


class ChosenContext(RunContext):
    """A run in which `arm.force` is what is chosen."""

    def reading(self, device: str, name: str) -> float:
        return 9.0 if Chosen.choose() else 0.0


@pytest.fixture(autouse=True, scope="module")
def nodes() -> Iterator[None]:
    registry.load_all()
    before = registry.load_all()
    for cls in (Give, Take):
        registry.node(cls)
    yield
    registry._nodes.clear()
    registry._nodes.update(before)


KEYS = st.sampled_from("abc")
leaf = (
    st.tuples(st.sampled_from(["give", "take"]), KEYS).map(lambda t: f"{t[0]}: {{key: ${t[1]}}}")
    | KEYS.map(lambda k: f"set: {{{k}: 1 mm}}")
    | st.tuples(KEYS, KEYS).map(lambda t: f"set: {{{t[0]}: {t[1]}}}")
    | st.just("check: arm.force > 5 N")
    | KEYS.map(lambda k: f"check: {k} > 0 mm")
    | st.just("fail: no")
)


def lists(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.lists(inner.map(lambda text: f"{{{text}}}"), min_size=1, max_size=3).map(
        lambda items: f"[{', '.join(items)}]"
    )


def composite(inner: st.SearchStrategy[str], *, odd: bool) -> st.SearchStrategy[str]:
    words = [
        "sequence",
        "selector",
        "reactive_sequence",
        "reactive_selector",
        "invert",
        "force_success",
        "force_failure",
    ]
    found = st.tuples(st.sampled_from(words), lists(inner)).map(lambda t: f"{t[0]}: {t[1]}")
    body = lists(inner)
    found |= body.map(lambda b: f"until: {{that: arm.force > 5 N, max: 2, do: {b}}}")
    found |= st.tuples(KEYS, body).map(lambda t: f"until: {{that: {t[0]} > 0 mm, max: 2, do: {t[1]}}}")
    found |= body.map(lambda b: f"repeat: {{times: 2, do: {b}}}")
    found |= body.map(lambda b: f"retry: {{attempts: 2, do: {b}}}")
    items = ["[1 mm]", "$list", *(["[]"] if odd else [])]
    found |= st.tuples(st.sampled_from(items), KEYS, body).map(
        lambda t: f"for_each: {{items: {t[0]}, as: ${t[1]}, do: {t[2]}}}"
    )
    found |= body.map(lambda b: f"sequence: {b}, skip_if: arm.force > 5 N")
    found |= st.tuples(KEYS, body).map(lambda t: f"sequence: {t[1]}, guard: {t[0]} > 0 mm")
    if odd:
        policies = st.sampled_from(["success_on_all", "success_on_one"])
        found |= st.tuples(policies, lists(inner)).map(lambda t: f"parallel: {{policy: {t[0]}, children: {t[1]}}}")
    return found


def trees(*, odd: bool) -> st.SearchStrategy[str]:
    return st.recursive(leaf, lambda inner: composite(inner, odd=odd), max_leaves=7).map(
        lambda body: (
            f"""
format: stretch-tree/1
devices: {{arm: Arm}}
params: {{list: {{type: "list[Length]", default: [1 mm]}}}}
keys: {{a: Length, b: Length, c: Length}}
trees: {{main: {{sequence: [{{{body}}}]}}}}
"""
        )
    )


def outcomes(program: Program, limit: int = 300) -> tuple[bool, bool]:
    """Return whether any run reads an unset key, and whether all runs were tried."""
    Chosen.choose.answers.clear()
    for number in Chosen.choose.runs(limit):
        root = build(program, ChosenContext()).root
        try:
            for _ in range(40):
                list(root.tick())
                if root.status is not Status.RUNNING:
                    break
        except UnsetKey:
            return True, True
        if number == limit - 1:
            return False, False
    return False, True


def checked(text: str, folder: Path) -> tuple[Program, set[str]]:
    path = folder / "tree.yaml"
    path.write_text(text)
    program = load_program(path)
    return program, {d.code for d in program.errors}


many = settings(max_examples=150, suppress_health_check=list(HealthCheck))


@many
@given(text=trees(odd=True))
def test_what_is_accepted_never_reads_an_unset_key(text: str, tmp_path: Path) -> None:
    program, codes = checked(text, tmp_path)
    event(f"accepted: {not codes}")
    if not codes:
        unset, _ = outcomes(program)
        assert not unset


@many
@given(text=trees(odd=False))
def test_what_is_refused_can_read_an_unset_key(text: str, tmp_path: Path) -> None:
    """Without branches side by side and loops over nothing, the check refuses only what can go wrong."""
    program, codes = checked(text, tmp_path)
    event(f"refused: {codes == {'read-before-write'}}")
    if codes == {"read-before-write"}:
        unset, complete = outcomes(program)
        assert unset or not complete


def test_branches_side_by_side_know_nothing_of_each_other(tmp_path: Path) -> None:
    """Here the check is stricter than the run, in which the first branch is ticked first."""
    body = "parallel: [{set: {a: 1 mm}}, {check: a > 0 mm}]"
    text = f"format: stretch-tree/1\nkeys: {{a: Length}}\ntrees: {{main: {{{body}}}}}\n"
    program, codes = checked(text, tmp_path)
    assert codes == {"read-before-write"}
    assert outcomes(program) == (False, True)
