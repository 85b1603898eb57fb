"""The page of what accuracy costs: one picture a domain, drawn from rows alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path

from stretch_bt.accuracy import file
from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import Domain
from stretch_bt.accuracy.picture import draw
from stretch_bt.accuracy.points import SKIPPED, Row
from stretch_bt.accuracy.registry import domains, names

__all__ = ["INDEX", "kept", "write"]

INDEX = "index.md"
_HEAD = """\
# What accuracy costs

One picture for each part of the package: the cost of an answer, across, and its error, up. Lower and further left is
better. A point is a setting at its medians; the ring is the default. A bar goes up to the 95th percentile of the cases where
these are 20 or more, with a flat end, else to the largest, with a pointed end. An open circle above counts the cases of a setting that
have no answer. The dashed line is the reference's own error, in the median: differences below it mean nothing. Squares are other programs.
Axes are logarithmic. "The cheapest within 1 %" is the setting with the least cost whose bar ends below 1 %.

The page is drawn from the files of rows beside it, without measuring anything:

```console
stretch-bt accuracy --from docs/accuracy/*.jsonl --page docs/accuracy
```

`stretch-bt accuracy --page DIR` measures all of it first, `stretch-bt accuracy membrane --page DIR` one part, and
`stretch-bt accuracy membrane --from docs/accuracy/membrane.jsonl` prints the numbers of the points.
"""


def kept(folder: Path, fresh: Collection[str] = ()) -> list[Row]:
    """Return the rows that a page was drawn from, but of the domains that are measured anew; none where there is no page."""
    found = sorted(path for name in names() if name not in fresh and (path := folder / f"{name}.jsonl").exists())
    return [row for path in found for row in file.read(path)]


def write(folder: Path, rows: Sequence[Row]) -> None:
    """Write the page of some rows, a picture and a file of rows for each domain, into a folder that is there."""
    chosen = domains(row.domain for row in rows) if rows else {}
    shares = {name: [row for row in rows if row.domain == name] for name in chosen}
    for name, share in shares.items():
        (folder / f"{name}.svg").write_text(draw(name, chosen[name], share), encoding="utf-8")
        file.write(folder / f"{name}.jsonl", share)
    (folder / INDEX).write_text(_page(chosen, shares), encoding="utf-8")


def _page(chosen: dict[str, Domain], shares: dict[str, list[Row]]) -> str:
    takes = {name: domain.take(DomainSummaries(domain, shares[name])) for name, domain in chosen.items()}
    lines = [f"| [{name}](#{name}) | {_default(domain, shares[name])} |" for name, domain in chosen.items()]
    table = "\n".join(["| part | the default, its error and its cost |", "|---|---|", *lines])
    sections = [_section(name, domain, shares[name], takes[name]) for name, domain in chosen.items()]
    return "\n".join([_HEAD, table, *sections])


def _default(domain: Domain, rows: Sequence[Row]) -> str:
    """Return the default of the first panel in words."""
    first = domain.panels[0]
    return DomainSummaries(domain, rows).default(first.kind, first.axis)


def _section(name: str, domain: Domain, rows: Sequence[Row], take: str) -> str:
    omitted = [f"- {what}: {why}" for what, why in domain.omitted.items()]
    parts = [
        f"\n## {name}\n",
        f"{take}\n",
        f"![{name}: error by cost]({name}.svg)\n",
        f"{domain.about}\n",
        "Omitted, and why:\n",
        "\n".join([*omitted, *_skipped(rows)]) + "\n",
        f"{_made(rows)}\n",
    ]
    return "\n".join(parts)


def _skipped(rows: Iterable[Row]) -> Iterator[str]:
    """Yield the settings that were not run, and why."""
    skipped = [row for row in rows if row.status == SKIPPED]
    counts = Counter(("most points" if row.reason == "quick" else row.setting.series, row.reason) for row in skipped)
    for (what, reason), count in counts.items():
        yield f"- {what}: not run, {reason}{f', {count} points' if count > 1 else ''}"


def _made(rows: Sequence[Row]) -> str:
    machines = Counter((row.cpu, row.commit) for row in rows)
    where = "; ".join(f"{cpu}, commit {commit or 'not known'}" for cpu, commit in machines)
    return f"[{len(rows)} rows]({rows[0].domain}.jsonl), made on {where}."
