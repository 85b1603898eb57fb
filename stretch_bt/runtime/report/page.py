"""report.html: what was run, how it ended, and what happened, on one page that needs no network."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.record.folder import REPORT, readable, refuse
from stretch_bt.runtime.report.details import commands, facts, faults, last_readings
from stretch_bt.runtime.report.history import History, gather
from stretch_bt.runtime.report.outputs import outputs
from stretch_bt.runtime.report.panels import panels
from stretch_bt.runtime.report.pictures import pictures
from stretch_bt.runtime.report.plot import plot
from stretch_bt.runtime.report.style import STYLE
from stretch_bt.runtime.report.text import escape, seconds, section
from stretch_bt.runtime.report.timeline import legend, timeline

__all__ = ["write_report"]


def write_report(folder: Path, out: Path | None = None) -> Path:
    """Write the report of a record, by default into its folder; return its path.

    Raises
    ------
    RecordError
        The folder holds no record, the report cannot be written, or its name does not end in .html or .htm.
    """
    record = RecordReader(folder)
    path = record.folder / REPORT if out is None else Path(out).absolute()
    if path.suffix.lower() not in (".html", ".htm"):
        raise refuse(path, "report-write", f"the report is a page in HTML; write a name such as {path.stem}.html")
    try:
        with readable(record.folder):
            page = _page(record)
        path.write_text(page, encoding="utf-8", errors="replace")
    except OSError as error:
        raise refuse(path, "report-write", f"cannot write the report: {error.strerror}") from error
    return path


def _page(record: RecordReader) -> str:
    history = gather(record)
    title = escape(_tree_name(record.header))
    body = "".join(
        (
            _head(record, title),
            section("Outputs", outputs(record.result or {})),
            last_readings(record, history),
            panels(record),
            section("Nodes over time", timeline(history.spans, history.start, history.end), legend()),
            section("Keys", _plots(history.keys, history), "each value holds until the next; the band is ± one sd"),
            section("Readings", _plots(history.readings, history), "as handed to nodes"),
            section("Depth frames", _grid(pictures(history.frames)), "bright is near; grey is invalid"),
            section("Device commands", commands(record)),
            section("Faults and notes", faults(record)),
            section("Tracebacks", _tracebacks(record.result or {}), "of nodes whose own code broke"),
            section("Run", facts(record)),
        )
    )
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style></head>'
        f"<body><main>{body}<footer>stretch-bt</footer></main></body></html>\n"
    )


def _tracebacks(result: dict[str, Any]) -> str:
    rows = [row for row in _listed(result.get("broken")) if isinstance(row, dict)]
    return "".join(f"<p>{escape(row.get('at', ''))}</p><pre>{escape(row.get('traceback', ''))}</pre>" for row in rows)


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _tree_name(header: dict[str, Any]) -> str:
    tree = header.get("tree", "run")
    if tree is None:
        return "calls from Python"
    return str(tree.get("name", "run")) if isinstance(tree, dict) else str(tree)


def _head(record: RecordReader, title: str) -> str:
    result = record.result or {}
    status = str(result.get("status", "UNFINISHED"))
    reason = result.get("reason") or (
        "" if record.complete else f"the record ends early, at {seconds(record.until)} s: its process was killed"
    )
    facts = "".join(f"<li>{name} <b>{escape(value)}</b></li>" for name, value in _headline(record, result))
    return (
        f'<header class="{escape(status.lower())}"><h1>{title} <span class="badge">{escape(status)}</span></h1>'
        + (f'<p class="reason">{escape(reason)}</p>' if reason else "")
        + f'<ul class="facts">{facts}</ul></header>'
    )


def _headline(record: RecordReader, result: dict[str, Any]) -> Iterator[tuple[str, str]]:
    for name in ("scene", "cell", "seed"):
        value = record.header.get(name)
        if value is not None:
            yield name, value.get("name", "") if isinstance(value, dict) else value
    choice = result.get("choice")
    if isinstance(choice, dict) and choice.get("asked"):
        yield "tolerance", str(choice.get("line", ""))
    yield "ticks", str(result.get("ticks", len(record.ticks)))
    for name, label in (("task_seconds", "task time"), ("wall_seconds", "wall time"), ("cpu_seconds", "CPU time")):
        if name in result:
            yield label, f"{seconds(result[name])} s"


def _plots(series: dict[str, Any], history: History) -> str:
    return _grid("".join(plot(one, history.start, history.end) for one in series.values()))


def _grid(content: str) -> str:
    return f'<div class="grid">{content}</div>' if content else ""
