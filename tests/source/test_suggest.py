"""Suggestions take no time that grows with what a file holds."""

import difflib
import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter

from stretch_bt.runtime.check import check
from stretch_bt.source import closest
from stretch_bt.source.schema import _schema
from stretch_bt.source.suggest import MOST

MANY = 400


def lines(form: str) -> str:
    """Return one line for each number, with # in its place."""
    return "".join(form.replace("#", str(number)) + "\n" for number in range(MANY))


def steps(form: str) -> str:
    return f"  main:\n    sequence:\n{lines('      - ' + form)}"


HEAD = "format: stretch-tree/1\n"
MISSPELT = {
    "keys": f"{HEAD}keys:\n{lines('  key_name_#: Length')}trees:\n{steps('check: $key_nama_# > 1 mm')}",
    "calls": f"{HEAD}trees:\n{lines('  call_name_#: {check: 1 mm > 0 mm}')}{steps('call_nama_#: {}')}",
    "params": f"{HEAD}params:\n{lines('  name_#: {type: Length, default: 1 mm}')}trees:\n{steps('check: nama_# > 1 mm')}",
    "ports": f"{HEAD}trees:\n  feel:\n    in:\n{lines('      port_name_#: Length')}    check: 1 mm > 0 mm\n"
    f"  main:\n    sequence:\n      - feel:\n{lines('          port_nama_#: 1 mm')}",
    "scene": f"format: stretch-scene/1\n{lines('nama_#: 1')}",
}


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Count the searches for a like word, the pairs of characters that they compare, and the schemas that are made."""
    count: Counter[str] = Counter()
    search, schema = difflib.get_close_matches, TypeAdapter.json_schema

    def searched(word: str, words: Any, **options: Any) -> list[str]:
        count["searches"] += 1
        count["pairs"] += len(word) * sum(map(len, words))
        return search(word, words, **options)

    def made(self: Any, *args: Any, **options: Any) -> Any:
        count["schemas"] += 1
        return schema(self, *args, **options)

    monkeypatch.setattr(difflib, "get_close_matches", searched)
    monkeypatch.setattr(TypeAdapter, "json_schema", made)
    _schema.cache_clear()
    return count


@pytest.mark.parametrize("what", MISSPELT)
def test_many_mistakes_among_many_names_are_compared_no_more_than_a_person_waits_for(
    what: str, counted: Counter[str], tmp_path: Path
) -> None:
    path = tmp_path / "file.yaml"
    path.write_text(MISSPELT[what])
    found = check([path])
    assert len(found) >= MANY
    assert all(d.message for d in found)
    assert counted["pairs"] <= MOST
    assert counted["schemas"] <= 1
    counted.clear()
    check([path])
    assert counted["searches"] > 0, "the next file has a bound of its own"


def test_each_of_twenty_mistakes_among_150_names_has_its_suggestion(tmp_path: Path) -> None:
    path = tmp_path / "file.yaml"
    names = "".join(f"  name_of_key_{k}: Length\n" for k in range(150))
    wrong = "".join(f"      - check: $nane_of_key_{k} > 1 mm\n" for k in range(20))
    path.write_text(f"{HEAD}keys:\n{names}trees:\n  main:\n    sequence:\n{wrong}")
    hints = [d.hint for d in check([path]) if d.severity == "error"]
    assert hints[:20] == [f"did you mean 'name_of_key_{k}'?" for k in range(20)]


def test_long_words_are_compared_with_nothing() -> None:
    random.seed(0)
    letters = [chr(code) for code in range(0x4E00, 0x9000)]
    long = ["".join(random.choices(letters, k=50_000)) for _ in range(3)]
    assert closest(long[0], long) is None  # comparing them takes minutes
    assert closest("depht", [*long, "depth"]) == "depth"


@pytest.mark.parametrize(
    ("file", "taken"),
    [
        ("format: stretch-scene/1\nobject: {type: sphere, diameter: 30 mm, diametre: 20 mm}\n", "diameter"),
        ("format: stretch-cell/1\ndevices: {arm: {driver: simulated}}\nlimits: {}\nlimit: {}\n", "limits"),
        ("format: stretch-sweep/1\ntree: palpate_stiffness\nseeds: 2\nseed: 3\n", "seeds"),
        (f"{HEAD}params: {{}}\nparam: {{}}\ntrees:\n  main:\n    sequence: [wait: {{duration: 1 s}}]\n", "params"),
    ],
)
def test_a_key_that_is_there_already_is_not_suggested_again(file: str, taken: str, tmp_path: Path) -> None:
    path = tmp_path / "file.yaml"
    path.write_text(file)
    hints = [d.hint for d in check([path]) if d.code == "key-unknown"]
    assert hints == [f"{taken!r} stands there already; remove one of them"]
