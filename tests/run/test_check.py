"""Seeded mistakes: each is found by `check` at its place, alone, with a hint that is right."""

import re
import textwrap
from pathlib import Path
from typing import Any

import pytest
import yaml

from stretch_bt import check

TABLES = Path(__file__).parents[1] / "mistakes"
MISTAKES = [
    pytest.param(entry, id=f"{table.stem}: {entry['name']}")
    for table in sorted(TABLES.glob("*.yaml"))
    for entry in yaml.safe_load(table.read_text("utf-8"))
]
#: what the mocks files of the tables are for
TREE = """
format: stretch-tree/1
devices: {arm: Arm, camera: DepthCamera}
keys: {height: {type: Length, default: 0 mm}}
trees:
  main:
    guard: arm.force < 5 N
    sequence: [press: {depth: 1 mm}, look: {height: $height}, press: {depth: 2 mm}]
    finally: [retract: {clearance: 20 mm}]
  look:
    out: {height: Length}
    keys: {frame: DepthFrame, contact: Contact}
    sequence:
      - capture: {frame: $frame}
      - segment_contact: {frame: $frame, contact: $contact}
      - track_height: {frame: $frame, contact: $contact, height: $height}
"""
MARKED = re.compile("«(.*?)»", re.DOTALL)


def tree_text(entry: dict[str, Any]) -> str:
    """Return a tree file with the body of main, and what else the entry gives."""
    body = textwrap.indent(entry["body"].strip(), "    ")
    trees = textwrap.indent(entry.get("trees", "").strip(), "  ")
    return f"format: stretch-tree/1\n{entry.get('head', '').strip()}\ntrees:\n  main:\n{body}\n{trees}\n"


def written(entry: dict[str, Any]) -> dict[str, str]:
    """Return the files of an entry by name, with the marks; the first is the one to check."""
    text = entry["file"] if "file" in entry else tree_text(entry)
    if "stretch-mocks" in text:
        return {"mocks.yaml": text, "tree.yaml": TREE, **entry.get("files", {})}
    return {"tree.yaml": text, **entry.get("files", {})}


def place(files: dict[str, str]) -> tuple[str, int, int, str]:
    """Return the file, line, column and text that the mark encloses."""
    [(name, text)] = [(name, text) for name, text in files.items() if MARKED.search(text)]
    match = MARKED.search(text)
    assert match is not None
    start = match.start()
    return name, text.count("\n", 0, start) + 1, start - (text.rfind("\n", 0, start) + 1) + 1, match[1]


def write(folder: Path, files: dict[str, str]) -> Path:
    """Write files without their marks and return the path of the first."""
    for name, text in files.items():
        (folder / name).write_text(MARKED.sub(r"\1", text), encoding="utf-8")
    return folder / next(iter(files))


def corrected(files: dict[str, str], fix: Any, hint: str) -> dict[str, str]:
    """Return the files as the hint wants them."""
    if isinstance(fix, dict):
        name = place(files)[0]
        text = MARKED.sub(r"\1", files[name])
        for old, new in fix.items():
            assert old in text, f"{old!r} is not in {name}"
            text = text.replace(old, new, 1)
        return {**files, name: text}
    quoted = re.search(r"'((?:[^']|'(?=\w))+)'", hint)
    assert quoted, f"the hint quotes nothing to write: {hint}"
    return {name: MARKED.sub(lambda _: quoted[1], text) for name, text in files.items()}


@pytest.mark.parametrize("entry", MISTAKES)
def test_each_mistake_is_found_at_its_place_with_a_hint_that_is_right(entry, tmp_path):
    files = written(entry)
    name, line, column, _ = place(files)
    path = write(tmp_path, files)
    found = [d for d in check([path]) if d.severity == "error"]
    main = next((d for d in found if d.code == entry["code"]), None)
    said = "\n".join(str(d) for d in found) or "nothing was found"
    assert main is not None, said
    assert (Path(main.file).name, main.line, main.column) == (name, line, column), said
    assert entry["hint"] in main.hint, said
    others = sorted(d.code for d in found if d is not main)
    assert others == sorted(entry.get("also", [])), said
    if "fix" in entry:
        again = write(tmp_path, corrected(files, entry["fix"], main.hint))
        left = [d for d in check([again]) if d.severity == "error"]
        assert left == [], f"after the correction by {main.hint!r}: {left}"
