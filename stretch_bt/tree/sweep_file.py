"""Sweep files: one tree or several, run once for each scene, seed and combination of params."""

from __future__ import annotations

import os
from dataclasses import dataclass
from math import inf, prod
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

from stretch_bt.errors import Diagnostic, FileError, InvalidInput, SweepError
from stretch_bt.simulation.scene.sections import Tolerance
from stretch_bt.source import Map, Mark, Scalar, Seq, Value, is_null, load, validate
from stretch_bt.tree.values import written
from stretch_bt.units import Time, parse_quantity
from stretch_bt.within import Within

__all__ = ["FORMAT", "SweepFile", "read_sweep", "sweep_schema"]

FORMAT = "stretch-sweep/1"
#: items of a sweep; more is a slip of the pen, and their keys alone would fill the memory
MOST = 10_000_000

_NAME: dict[str, Any] = {"type": "string", "minLength": 1}
_NAMES = {"anyOf": [_NAME, {"type": "array", "items": _NAME, "minItems": 1}]}
_PLAIN: dict[str, Any] = {"type": ["string", "number", "boolean"]}
_VALUES = {"anyOf": [_PLAIN, {"type": "array", "items": {"anyOf": [_PLAIN, {"type": "array"}]}, "minItems": 1}]}
_SEEDS = {
    "anyOf": [
        {"type": "integer", "minimum": 1},
        {
            "type": "object",
            "properties": {"from": {"type": "integer", "minimum": 0}, "count": {"type": "integer", "minimum": 1}},
            "required": ["count"],
            "additionalProperties": False,
        },
    ]
}


def _listed(given: Any) -> Any:
    return given if isinstance(given, list) else [given]


def _counted(given: Any) -> Any:
    """Return a count of seeds as its mapping."""
    if isinstance(given, int) and not isinstance(given, bool):
        return {"from": 0, "count": given}
    if not isinstance(given, dict):
        raise InvalidInput(f"{given!r} is no number of seeds; write 6 for 0 to 5, or {{from: 10, count: 50}}")
    return given


_Name = Annotated[str, Field(min_length=1)]
_Names = Annotated[list[_Name], Field(min_length=1), BeforeValidator(_listed), WithJsonSchema(_NAMES)]
_Choices = Annotated[list[Any], Field(min_length=1), BeforeValidator(_listed), WithJsonSchema(_VALUES)]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class _Seeds(_Model):
    """Seeds from the first on."""

    first: int = Field(default=0, ge=0, alias="from")
    count: int = Field(ge=1)


class _SweepFile(_Model):
    """A sweep file."""

    format: Literal["stretch-sweep/1"]
    doc: str = Field(default="", description="purpose of the sweep")
    tree: _Names = Field(
        examples=["palpate_stiffness"],
        description="a tree file relative to this one, the name of a shipped tree, or a list of them",
    )
    scene: _Names | None = Field(
        default=None,
        examples=["water_balloon"],
        description="a scene file relative to this one, a shipped scene, or a list; by default each tree's own",
    )
    cell: _Name | None = Field(
        default=None,
        examples=["simulated"],
        description="a cell file relative to this one, or a shipped cell: simulated",
    )
    seeds: Annotated[_Seeds, BeforeValidator(_counted), WithJsonSchema(_SEEDS)] = Field(
        default=_Seeds(count=1),
        examples=[6],
        description="number of seeds from 0 on, or `{from: 10, count: 50}`",
        validate_default=False,
    )
    set: dict[str, _Choices] = Field(
        default={}, description="params of the trees: one value, or a list; each combination is run"
    )
    tolerance: Tolerance | None = Field(
        default=None, description="tolerance that `effects: auto` goes by, instead of the scene's"
    )
    limit: Annotated[Time, Within(0.001, 1e7, "Time")] | None = Field(
        default=None, description="wall time of an item, after which it is stopped at its next tick and is `timed_out`"
    )
    record: Literal["full", "events", "none"] = Field(default="none", description="part of each run that is kept")


@dataclass(frozen=True, slots=True)
class SweepFile:
    """A sweep file as it was written, each name and value at its place; `tolerance` in SI, `limit` in s."""

    file: str
    path: Path
    doc: str
    trees: tuple[Scalar, ...]
    scenes: tuple[Scalar, ...]
    cell: Scalar | None
    seeds: range
    choices: dict[str, tuple[Value, ...]]
    marks: dict[str, Mark]
    tolerance: dict[str, float]
    limit: float | None
    record: Literal["full", "events", "none"]

    @property
    def folder(self) -> Path:
        """The folder that names in it are relative to."""
        return self.path.parent

    def place(self, name: Scalar) -> str:
        """Return the path of a file that is named, or the name of a shipped one, which no file beside hides."""
        beside = self.folder / name.text
        return str(beside) if name.text.endswith((".yaml", ".yml")) or beside.is_file() else name.text

    def __len__(self) -> int:
        """Return how many items there are."""
        scenes = max(len(self.scenes), 1)
        return len(self.trees) * scenes * len(self.seeds) * prod(len(values) for values in self.choices.values())


def read_sweep(path: str | Path) -> tuple[SweepFile, list[Diagnostic]]:
    """Read a sweep file, not the files that it names; return also every mistake in it. A wrong key counts as left out.

    Raises
    ------
    SweepError
        Nothing of it can be read.
    """
    file = str(path)
    try:
        source = load(Path(path), file)
    except FileError as error:
        raise SweepError(error.diagnostics) from None
    wrong: list[Diagnostic] = []
    try:
        made, right = validate(_SweepFile, source), source
    except FileError as error:
        wrong = sorted(error.diagnostics, key=lambda d: (d.line, d.column))
        if any(d.code == "format-unknown" for d in wrong):  # a file of another kind
            raise SweepError(wrong) from None
        right = _without_wrong(source, wrong)
        made = _of_what_is_right(right)
    table = _params(source, wrong)
    found = SweepFile(
        file=file,
        path=Path(path),
        doc=made.doc,
        trees=_scalars(right.get("tree")),
        scenes=_scalars(right.get("scene")),
        cell=next(iter(_scalars(right.get("cell"))), None),
        seeds=range(made.seeds.first, made.seeds.first + made.seeds.count),
        choices={key.text: _choices(value) for key, value in table},
        marks={key.text: key.mark for key, _ in table},
        tolerance={} if made.tolerance is None else made.tolerance.named(),
        limit=made.limit,
        record=made.record,
    )
    return found, [*wrong, *_twice(found), *_too_many(found, source)]


def _without_wrong(found: Map, wrong: list[Diagnostic]) -> Map:
    """Return a mapping without the keys in which one of the mistakes stands; those behind it in the file are in none."""
    return Map(tuple(pair for pair in found.pairs if not _within(found, pair[0], wrong)), found.mark)


def _within(found: Map, key: Scalar, wrong: list[Diagnostic]) -> list[Diagnostic]:
    """Return the mistakes that stand between a key of a mapping and the next one."""
    begins = [(k.mark.line, k.mark.column) for k, _ in found]
    begin = (key.mark.line, key.mark.column)
    end = min((place for place in begins if place > begin), default=(inf, 0.0))
    return [d for d in wrong if begin <= (d.line, d.column) < end]


def _params(source: Map, wrong: list[Diagnostic]) -> tuple[tuple[Scalar, Value], ...]:
    """Return the params under `set` in which nothing is wrong, each with its values."""
    for key, value in source:
        if key.text == "set" and isinstance(value, Map):
            return _without_wrong(value, _within(source, key, wrong)).pairs
    return ()


def _of_what_is_right(source: Map) -> _SweepFile:
    try:
        return validate(_SweepFile, source)
    except FileError:  # one that needs a key which is left out
        return _SweepFile.model_construct()


def sweep_schema() -> dict[str, Any]:
    """Return the JSON Schema of sweep files."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_SweepFile.model_json_schema()}


def _scalars(value: Value | None) -> tuple[Scalar, ...]:
    items = value.items if isinstance(value, Seq) else (value,)
    return tuple(item for item in items if isinstance(item, Scalar) and not is_null(item))


def _choices(value: Value) -> tuple[Value, ...]:
    return value.items if isinstance(value, Seq) else (value,)


def _twice(found: SweepFile) -> list[Diagnostic]:
    """Return each value that a list has twice: its items would be the same."""
    lists: dict[str, list[tuple[Value, str]]] = {
        name: [(value, _in_si(written(value))) for value in values] for name, values in found.choices.items()
    }
    for name, files in (("tree", found.trees), ("scene", found.scenes)):
        lists[name] = [(value, os.path.realpath(found.place(value))) for value in files]
    wrong = []
    for name, values in lists.items():
        seen: dict[str, str] = {}
        for value, meant in values:
            text = written(value)
            if meant in seen:
                twice = (
                    f"{text!r} twice" if seen[meant] == text else f"{seen[meant]!r} and {text!r}, which are the same"
                )
                wrong.append(value.mark.error("value", f"{name} has {twice}", "write each value once"))
            seen.setdefault(meant, text)
    return wrong


def _in_si(text: str) -> str:
    """Return a number with its unit in SI, rounded, so that `1 mm` is `0.1 cm`; any other text as it is."""
    try:
        number, dimension = parse_quantity(text)
    except InvalidInput:
        return text
    return f"{number:.12g} {dimension}" if any(dimension) else text


def _too_many(found: SweepFile, source: Map) -> list[Diagnostic]:
    count = len(found)
    if count <= MOST:
        return []
    message = f"the sweep has {count:,} items, and {MOST:,} are run at most"
    return [source.mark.error("value", message, "take fewer seeds or values, or write several sweeps")]
