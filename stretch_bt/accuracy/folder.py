"""A folder of rows: `accuracy.jsonl`, `accuracy.csv`, and a picture for each domain."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from stretch_bt.accuracy import file
from stretch_bt.accuracy.picture import draw
from stretch_bt.accuracy.points import Row
from stretch_bt.accuracy.registry import domains

__all__ = ["write"]


def write(folder: Path, rows: Sequence[Row]) -> None:
    """Write rows, and the picture of each domain among them, into a folder that is there."""
    file.write(folder / "accuracy.jsonl", rows)
    with (folder / "accuracy.csv").open("w", encoding="utf-8", newline="") as opened:
        table = csv.DictWriter(opened, [*Row.__slots__])
        table.writeheader()
        table.writerows(_flat(row) for row in rows)
    for name, domain in domains(row.domain for row in rows).items() if rows else ():
        picture = draw(name, domain, [row for row in rows if row.domain == name])
        (folder / f"{name}.svg").write_text(picture, encoding="utf-8")


def _flat(row: Row) -> dict[str, object]:
    versions = " ".join(f"{name}={version}" for name, version in row.versions.items())
    cost = "" if row.cost is None else f"{row.cost.value:g} {row.cost.name}"
    return row.to_json() | {"versions": versions, "setting": str(row.setting), "cost": cost}
