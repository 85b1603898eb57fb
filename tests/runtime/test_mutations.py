"""Valid trees changed at random never break the check; changes of meaning are never accepted in silence."""

import copy
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stretch_bt.errors import Diagnostic
from stretch_bt.runtime.check import check_file
from stretch_bt.runtime.context import RunContext
from stretch_bt.source import Map, Scalar, Seq, Value, parse
from stretch_bt.tree.build import build
from stretch_bt.tree.program import load_program, shipped_trees
from stretch_bt.tree.registry import lookup
from stretch_bt.tree.shared import shipped
from stretch_bt.units import KINDS, parse_quantity, parse_unit

T = TypeVar("T")
SAMPLES = [Path(__file__).parent / "samples" / "every_construct.yaml", *(shipped(f"{t}.yaml") for t in shipped_trees())]
PATHS = {path.stem: path for path in SAMPLES}
TEXTS = {path.stem: path.read_text("utf-8") for path in SAMPLES}
#: samples that each say much the same as another sample
ALIKE = ("palpate_active", "palpate_stiffness", "form_cookie", "form_cookie_fast", "contact_sensitivity", "reconstruct")
samples = pytest.mark.parametrize(
    "sample", [pytest.param(name, marks=[pytest.mark.slow] * (name in ALIKE)) for name in TEXTS]
)
WORD = re.compile(r"[\w$.]+")
NUMBER_AND_UNIT = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?) (mm/s|mm|ms|s|N/mm|N|deg|kPa|Pa)\b(?!\s*[:\w])")


def findings(text: str, folder: Path) -> list[Diagnostic]:
    path = folder / "tree.yaml"
    path.write_text(text, encoding="utf-8")
    return check_file(path)


@samples
def test_the_samples_are_right(sample: str, tmp_path: Path) -> None:
    assert findings(TEXTS[sample], tmp_path) == []


# --- random changes


def replaced(text: str, match: re.Match[str], new: str) -> str:
    return text[: match.start()] + new + text[match.end() :]


@st.composite
def mutated(draw: st.DrawFn) -> str:
    """Draw a sample with one to three changes of its text."""
    text = draw(st.sampled_from(list(TEXTS.values())))
    for _ in range(draw(st.integers(1, 3))):
        lines = text.split("\n")
        at = draw(st.integers(0, len(lines) - 1))
        words = list(WORD.finditer(text)) or [re.match("", text)]
        word = draw(st.sampled_from(words))
        assert word is not None
        kind = draw(
            st.sampled_from(
                ["delete", "double", "swap", "indent", "outdent", "word", "rename", "insert", "unquote", "cut"]
            )
        )
        if kind == "delete":
            text = "\n".join(lines[:at] + lines[at + 1 :])
        elif kind == "double":
            text = "\n".join([*lines[: at + 1], *lines[at:]])
        elif kind == "swap":
            text = "\n".join(lines[:at] + lines[at : at + 2][::-1] + lines[at + 2 :])
        elif kind == "indent":
            lines[at] = draw(st.sampled_from([" ", "  ", "\t"])) + lines[at]
            text = "\n".join(lines)
        elif kind == "outdent":
            lines[at] = lines[at].removeprefix("  ")
            text = "\n".join(lines)
        elif kind == "word":
            other = draw(st.sampled_from(words))
            assert other is not None
            text = replaced(text, word, other[0])
        elif kind == "rename":
            text = replaced(text, word, word[0][:-1] if draw(st.booleans()) else word[0] + "x")
        elif kind == "insert":
            place = draw(st.integers(0, len(text)))
            text = (
                text[:place] + draw(st.sampled_from([*"{}[]:,-'\"#&*!|>%@`$ \t\n~?0.=()<", "- ", ": "])) + text[place:]
            )
        elif kind == "unquote":
            text = text.replace(draw(st.sampled_from(["'", '"'])), "", draw(st.integers(1, 4)))
        else:
            text = text[: draw(st.integers(0, len(text)))]
    return text


@settings(
    max_examples=120, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
@given(text=mutated())
def test_any_change_is_judged_without_a_traceback(text: str, tmp_path: Path) -> None:
    found = findings(text, tmp_path)
    rows = text.split("\n")
    for finding in found:
        if Path(finding.file).name == "tree.yaml":  # and not a file that it imports
            assert 1 <= finding.line <= len(rows) + 1, finding
            assert 1 <= finding.column <= len(rows[finding.line - 1] if finding.line <= len(rows) else "") + 1, finding
        assert finding.message, finding
        assert finding.hint, finding
    if (
        all(finding.severity == "warning" for finding in found)
        and "main" in load_program(tmp_path / "tree.yaml").document.trees
    ):
        build(load_program(tmp_path / "tree.yaml").require(), RunContext())


# --- changes of meaning


Role = tuple[str | bool, ...]


def first_in_role(sample: str, roles: Callable[[str], Iterator[tuple[Role, T]]]) -> list[T]:
    """Return one value of a sample for each role that no sample before it has: a change of the rest is judged by the same code."""
    names = sorted(TEXTS, key=ALIKE.__contains__)
    before = {role for other in names[: names.index(sample)] for role, _ in roles(other)}
    found: dict[Role, T] = {}
    for role, value in roles(sample):
        if role not in before:
            found.setdefault(role, value)
    return list(found.values())


def keys(value: Value, parent: str = "") -> Iterator[tuple[Role, Scalar]]:
    """Yield every key of a file; its role is what it says in what."""
    for key, inner in value if isinstance(value, Map) else ():
        yield (parent, key.text), key
        yield from keys(inner, key.text)
    for item in value.items if isinstance(value, Seq) else ():
        yield from keys(item, parent)


def changed(text: str, scalar: Scalar, new: str) -> str:
    lines = text.split("\n")
    row, column = scalar.mark.line - 1, scalar.mark.column - 1
    lines[row] = lines[row][:column] + new + lines[row][column + len(scalar.text) :]
    return "\n".join(lines)


@samples
def test_no_key_of_a_file_can_be_renamed_in_silence(sample: str, tmp_path: Path) -> None:
    """Headings, nodes, ports, constructs and reserved words; and declared names, because each is used."""
    root = parse(TEXTS[sample], "a.yaml")
    assert isinstance(root, Map)
    by_kind = [key.text for _, key in keys(root.get("devices") or root)]  # a device may be found by its kind alone
    for key in first_in_role(sample, lambda name: keys(parse(TEXTS[name], "a.yaml"))):
        if key.text in by_kind:
            continue
        text = changed(TEXTS[sample], key, f"{key.text}q")
        assert findings(text, tmp_path), f"{key.text!r} on line {key.mark.line} was renamed and nobody noticed"


def quantities(sample: str) -> Iterator[tuple[Role, re.Match[str]]]:
    """Find every quantity of a sample that is no prose, also in expressions; its role is its unit and the word before it."""
    text = one_line_a_doc(sample)
    prose = [(m.start(), m.end()) for m in re.finditer(r"(?:doc|fail|log): .*?(?=[,}\n]|$)|#.*", text)]
    for match in NUMBER_AND_UNIT.finditer(text):
        if not any(start <= match.start() < end for start, end in prose):
            before = WORD.findall(text[text.rfind("\n", 0, match.start()) + 1 : match.start()])
            yield (match[2], *before[-1:]), match


def one_line_a_doc(sample: str) -> str:
    return TEXTS[sample].replace("\ndoc: >\n", "\ndoc: |\n")


@samples
def test_no_unit_can_be_dropped_or_exchanged_in_silence(sample: str, tmp_path: Path) -> None:
    text = one_line_a_doc(sample)
    assert len(list(quantities(sample))) >= 3
    for match in first_in_role(sample, quantities):
        dimension = parse_unit(match[2])[1]
        others = [kind.unit for kind in KINDS.values() if kind.dimension != dimension]
        for new in (match[1], *(f"{match[1]} {unit}" for unit in others[:1]), f"{match[1]} parsec"):
            assert findings(replaced(text, match, new), tmp_path), f"{match[0]!r} became {new!r} and nobody noticed"


Path_ = tuple[Any, ...]


def places(value: Any, path: Path_ = ()) -> Iterator[tuple[Path_, Any]]:
    """Yield every value of plain data with the way to it."""
    yield path, value
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in inner:
        yield from places(item, (*path, key))


def without(root: Any, path: Path_) -> Any:
    made = copy.deepcopy(root)
    parent = made
    for step in path[:-1]:
        parent = parent[step]
    del parent[path[-1]]
    return made


def with_value(root: Any, path: Path_, value: Any) -> Any:
    made = copy.deepcopy(root)
    parent = made
    for step in path[:-1]:
        parent = parent[step]
    parent[path[-1]] = value
    return made


def plain(sample: str) -> Any:
    return parse(TEXTS[sample], "a.yaml").plain()


def dumped(root: Any) -> str:
    return re.sub(
        r": null$", ":", yaml.safe_dump(root, sort_keys=False, allow_unicode=True, width=10_000), flags=re.MULTILINE
    )


@samples
def test_the_samples_are_right_when_written_otherwise(sample: str, tmp_path: Path) -> None:
    assert findings(dumped(plain(sample)), tmp_path) == []


def needed(sample: str) -> Iterator[tuple[Role, Path_]]:
    """Find every port and bound of a sample that cannot be left out, with its role: its name in what.

    A record that is left out is the one of its name, so that none of them is needed.
    """
    root = plain(sample)
    bounds = {
        "until": ("max", "that", "do"),
        "repeat": ("times", "do"),
        "retry": ("attempts", "do"),
        "for_each": ("items", "as", "do"),
    }
    trees = load_program(PATHS[sample]).document.trees
    for path, _ in places(root):
        if len(path) < 2 or not isinstance(path[-1], str):
            continue
        name = path[-2]
        info = lookup(str(name))
        ports = info.ports.values() if info else ()
        required = [p.name for p in ports if p.required and info and not info.types[p.name].is_record]
        required = required if info else bounds.get(name, ())
        if name in root["trees"] and path[-3] != "trees":
            inputs = trees[name].ins.items()
            required = [given for given, declared in inputs if not (declared.has_default or declared.type.is_record)]
        if path[-1] in required:
            yield (str(name), path[-1]), path


@samples
def test_no_required_port_and_no_bound_of_a_loop_can_be_left_out(sample: str, tmp_path: Path) -> None:
    root = plain(sample)
    assert len(list(needed(sample))) > 2
    for path in first_in_role(sample, needed):
        assert findings(dumped(without(root, path)), tmp_path), path


@samples
def test_no_number_can_be_pushed_out_of_its_bounds(sample: str, tmp_path: Path) -> None:
    root = plain(sample)
    for name, spec in root["params"].items():
        whole = spec.get("type", type(spec.get("default")).__name__) == "int"
        for bound, way in (("min", -0.1), ("max", 0.1)):
            if bound not in spec:
                continue
            text = str(spec[bound])
            number, unit = (text, "") if not NUMBER_AND_UNIT.fullmatch(text) else text.split()
            outside = float(number) + way * abs(float(number)) if float(number) else -1.0
            value = f"{outside:g} {unit}".strip() if unit else (int(outside) if whole else outside)
            if whole:
                value = int(number) + (1 if bound == "max" else -1)
            default = [value] if spec.get("type", "").startswith("list") else value
            assert findings(dumped(with_value(root, ("params", name, "default"), default)), tmp_path), (name, default)


@samples
def test_no_port_takes_a_number_out_of_its_bounds(sample: str, tmp_path: Path) -> None:
    root = plain(sample)
    for path, value in places(root):
        info = lookup(str(path[-2])) if len(path) > 1 else None
        port = info.ports.get(str(path[-1])) if info else None
        if port is None or port.max is None or not isinstance(value, str) or "$" in value or "(" in value:
            continue
        unit = value.split()[-1]
        assert parse_quantity(f"1 {unit}")
        assert findings(dumped(with_value(root, path, f"1e9 {unit}")), tmp_path), path


@samples
def test_no_option_or_name_can_be_misspelt_in_silence(sample: str, tmp_path: Path) -> None:
    """Words that are values: keys, options, policies, types, devices."""
    root = plain(sample)
    assert len(list(named(sample))) > 2
    for path, value in first_in_role(sample, named):
        assert findings(dumped(with_value(root, path, f"{value}q")), tmp_path), (path, value)


def named(sample: str) -> Iterator[tuple[Role, tuple[Path_, str]]]:
    """Find every word of a sample that is a value; its role is its last two keys, and whether it is the name of a value."""
    free = {
        "doc",
        "name",
        "log",
        "fail",
        "format",
        "unit",
        "model",
    }  # a model may be a file, which only a run looks for
    for path, value in places(plain(sample)):
        said = [step for step in path if isinstance(step, str)][-2:]
        if (
            isinstance(value, str)
            and re.fullmatch(r"\$?[A-Za-z_]\w*", value)
            and not free & {str(p) for p in path[-2:]}
        ):
            yield (*said, value[0] == "$"), (path, value)
