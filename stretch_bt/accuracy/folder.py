"""A folder of rows: `accuracy.json`, `accuracy.csv`, and a picture for each domain."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path

from stretch_bt.accuracy.picture import draw
from stretch_bt.accuracy.points import Row
from stretch_bt.accuracy.registry import domains

__all__ = ["write"]


def write(folder: Path, rows: Sequence[Row]) -> None:
    """Write rows, and the picture of each domain among them, into a folder that is there."""
    plain = [row.to_json() for row in rows]
    (folder / "accuracy.json").write_text(json.dumps(plain, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    with (folder / "accuracy.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, [*Row.__slots__])
        table.writeheader()
        for row in plain:
            versions = " ".join(f"{name}={version}" for name, version in row["versions"].items())
            table.writerow(row | {"versions": versions})
    for name, domain in domains(row.domain for row in rows).items() if rows else ():
        picture = draw(name, domain.KINDS, [row for row in rows if row.domain == name])
        (folder / f"{name}.svg").write_text(picture, encoding="utf-8")
