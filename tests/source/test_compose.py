"""YAML 1.2 core values with their places; anchors are copies."""

import math
import re
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import FileError
from stretch_bt.source import Map, Scalar, Seq, Value, lines_of, parse

#: what YAML 1.1, and so most tools for Python, reads otherwise
CORE = {
    "yes": "yes",
    "NO": "NO",
    "on": "on",
    "true": True,
    "False": False,
    "~": None,
    "null": None,
    "": None,
    "012": 12,
    "08": 8,
    "0o12": 10,
    "0x1F": 31,
    "1e-3": 0.001,
    "2e3": 2000.0,
    ".5": 0.5,
    "12:30": "12:30",
    "1_000": "1_000",
    "2026-01-01": "2026-01-01",
    ".inf": math.inf,
    "-.INF": -math.inf,
    "9" * 5000: math.inf,
    "'1'": "1",
    '"true"': "true",
    "'~'": "~",
}


@pytest.mark.parametrize("text", CORE)
def test_scalars_are_those_of_the_core_schema(text: str) -> None:
    value = parse(f"a: {text}\n", "a.yaml").plain()["a"]  # type: ignore[call-overload]
    assert type(value) is type(CORE[text])
    assert value == CORE[text]


def test_not_a_number_is_read_as_one() -> None:
    assert math.isnan(parse("a: .nan", "a.yaml").plain()["a"])  # type: ignore[call-overload]


def nodes(value: Value) -> list[Value]:
    inner = value.items if isinstance(value, Seq) else [v for _, v in value] if isinstance(value, Map) else []
    return [value, *(node for item in inner for node in nodes(item))]


def test_anchors_give_equal_values_and_never_the_same_object() -> None:
    root = parse("a: &x {p: [1, {q: 2}]}\nb: *x\nc: [*x, *x]\n", "a.yaml")
    assert root.plain() == {"a": {"p": [1, {"q": 2}]}, "b": {"p": [1, {"q": 2}]}, "c": [{"p": [1, {"q": 2}]}] * 2}  # type: ignore[comparison-overlap]
    containers = [node for node in nodes(root) if not isinstance(node, Scalar)]
    assert len({id(node) for node in containers}) == len(containers)


# text in YAML 1.1, which PyYAML writes, and a number in 1.2
NUMBER_SINCE_1_2 = re.compile(r"[-+]?\d+[eE][-+]?\d+|0o[0-7]+|[-+]?0\d+")

plain_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**9), 10**9)
    | st.text(st.characters(codec="utf-8", exclude_categories=["C"])).filter(
        lambda text: not NUMBER_SINCE_1_2.fullmatch(text)
    ),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text("abcxyz_", min_size=1), inner, max_size=4),
    max_leaves=20,
)


@given(st.dictionaries(st.text("abcxyz_", min_size=1), plain_values, max_size=4), st.booleans())
def test_what_pyyaml_writes_is_read_again(value: Any, flow: bool) -> None:
    text = yaml.safe_dump(value, default_flow_style=flow, allow_unicode=True)
    if not value:
        return
    assert parse(text, "a.yaml").plain() == value


@given(st.text(st.sampled_from("ab1: -[]{},'\"#&*!|>%@`\n\t<?~\r\x85\u2028\x07ü\U0001f600\udce9"), max_size=60))
def test_any_text_is_read_or_refused_at_a_place_inside_it(text: str) -> None:
    try:
        value = parse(text, "a.yaml")
    except FileError as error:
        [found] = error.diagnostics
        lines = lines_of(text + "\n")
        assert 1 <= found.line <= len(lines) + 1
        assert found.column >= 1
        assert found.message
        assert found.hint
    else:
        for node in nodes(value):
            row = lines_of(f"{text}\n")[node.mark.line - 1]
            assert node.mark.column <= len(row) + 1


@pytest.mark.parametrize("text", ["a: µm\nb: {ü: [1, x]}", "ä: {x: y}"])
def test_columns_count_characters(text: str) -> None:
    for node in nodes(parse(text, "a.yaml")):
        if isinstance(node, Scalar):
            row = text.split("\n")[node.mark.line - 1]
            assert row[node.mark.column - 1 :].startswith(node.text)


BREAKS = ["\n", "\r\n", "\r", "\x85", "\u2028", "\u2029"]
#: text with an end of line at each / -> line and column of its mistake, and the message
MISTAKES = {
    "a: 1/trees: {main: {sequence: [wait/": (2, 26, "the '[' that opens here is not closed"),
    "doc: Härte ± 1 µm, 😀/b: \x07 1/": (2, 4, r"the character '\x07' is forbidden"),
    "# ü/a: x/b: ü \udce9/": (3, 6, r"the character '\udce9' is forbidden"),
    "a: 1/b: 'x/": (2, 4, "the quote that opens here is never closed"),
    "a: ü/b: [1, 2} /": (2, 9, "',' or ']' is missing here"),
    "a: 1/b: %x": (2, 4, "text cannot begin with '%'"),
}


@pytest.mark.parametrize("ending", BREAKS)
@pytest.mark.parametrize("text", MISTAKES)
def test_a_mistake_is_named_at_its_place_whatever_ends_lines(text: str, ending: str) -> None:
    line, column, message = MISTAKES[text]
    with pytest.raises(FileError, match=re.escape(message)) as refused:
        parse(text.replace("/", ending), "a.yaml")
    [found] = refused.value.diagnostics
    assert (found.line, found.column) == (line, column)


@pytest.mark.parametrize("levels", [100, 149, 150, 200, 5000])
def test_a_chain_of_anchors_is_no_deeper_than_brackets_may_be(levels: int) -> None:
    text = "- &a0 [x]\n" + "".join(f"- &a{k} [*a{k - 1}]\n" for k in range(1, 100))
    text += f"- {'[' * (levels - 100)}*a99{']' * (levels - 100)}\n"  # values stay under their bound, levels do not
    if levels <= 149:
        assert isinstance(parse(text, "f.yaml"), Seq)
    else:
        with pytest.raises(FileError, match="nesting deeper than 150"):
            parse(text, "f.yaml")
