"""The tables of a report: last readings, commands, faults, and what was run."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from stretch_bt.frames import DepthFrame, Pose, Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.report.history import History
from stretch_bt.runtime.report.text import escape, number, seconds, section, table

__all__ = ["commands", "facts", "faults", "last_readings"]

MAX_ROWS = 500
_SHOWN_ELSEWHERE = ("status", "write", "command", "motion")


def last_readings(record: RecordReader, history: History) -> str:
    """Return the node that failed and the last readings, for a run that did not succeed."""
    if (record.result or {}).get("status") == "SUCCESS":
        return ""
    failures = [e for e in record.events if e["type"] == "status" and e["status"] == "FAILURE" and e.get("reason")]
    note = ""
    if failures:
        last = [event for event in failures if event["tick"] == failures[-1]["tick"]]
        failure = max(last, key=lambda event: event["path"].count("/"))
        note = f"<code>{escape(failure['path'])}</code> at {seconds(failure['time'])} s: {escape(failure['reason'])}"
    rows = [(escape(d), escape(name), _show(r.value), *_times(r)) for d, name, r in history.last]
    content = table(("device", "reading", "value", "device time, s", "number"), rows, (3, 4)) if rows else ""
    return section("Last readings", content or (" " if note else ""), note)


def _times(reading: Reading[Any]) -> tuple[str, ...]:
    return escape(seconds(reading.device_time)), escape(number(reading.sequence))


def _show(value: Any) -> str:
    if isinstance(value, Pose):
        place, turn = _list(value.position, 1e3), _list(value.rotation, 1.0)
        return f"({place}) mm, rotation ({turn}) rad"
    if isinstance(value, Wrench):
        return f"force ({_list(value.force, 1.0)}) N, torque ({_list(value.torque, 1.0)}) N m"
    if isinstance(value, DepthFrame):
        return escape(f"{value.raw.shape[1]} × {value.raw.shape[0]} depth frame {value.sequence}")
    return escape(number(value, 6))


def _list(values: tuple[float, ...], scale: float) -> str:
    return ", ".join(number(value * scale) for value in values)


def commands(record: RecordReader) -> str:
    """Return the table of commands that nodes gave."""
    given = [event for event in record.events if event["type"] == "command"]
    rows = [
        (
            seconds(e["time"]),
            escape(f"{e['device']}.{e['name']}"),
            _arguments(e["arguments"]),
            f"<code>{escape(e['owner'])}</code>",
        )
        for e in given[:MAX_ROWS]
    ]
    return table(("time, s", "command", "arguments, SI", "given by"), rows, (0,)) + _more(len(given)) if rows else ""


def _arguments(arguments: dict[str, Any]) -> str:
    return "<br>".join(f"{escape(name)} <code>{escape(_compact(value))}</code>" for name, value in arguments.items())


def _compact(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return f"({', '.join(_compact(item) for item in value)})"
    if isinstance(value, dict):
        return ", ".join(f"{name} {_compact(item)}" for name, item in value.items())
    return str(value)


def faults(record: RecordReader) -> str:
    """Return the table of faults that reached nodes, and of what the runner noted."""
    found = [event for event in record.events if event["type"] not in _SHOWN_ELSEWHERE]
    rows = [(seconds(e["time"]), escape(e["type"]), escape(_sentence(e))) for e in found[:MAX_ROWS]]
    return table(("time, s", "what", "details"), rows, (0,)) + _more(len(found)) if rows else ""


def _sentence(event: dict[str, Any]) -> str:
    if event["type"] == "fault":
        return f"{event['device']} {event['kind']}: {event['reason']}"
    return ", ".join(f"{name} {_compact(v)}" for name, v in event.items() if name not in ("tick", "time", "type") and v)


def _more(count: int) -> str:
    return f'<p class="note">and {count - MAX_ROWS} more in events.jsonl</p>' if count > MAX_ROWS else ""


def facts(record: RecordReader) -> str:
    """Return everything that the header and run.json say."""
    header = {k: v for k, v in record.header.items() if k not in ("type", "format", "keys")}
    parts = []
    for title, content in (("What was run", header), ("Where and when", record.run_info)):
        rows = [(escape(name), f"<code>{escape(value)}</code>") for name, value in _flat("", content)]
        if rows:
            parts.append(f"<details><summary>{title}</summary>{table(('name', 'value'), rows)}</details>")
    return "".join(parts)


def _flat(prefix: str, content: Any) -> Iterator[tuple[str, str]]:
    if isinstance(content, dict):
        for name, value in content.items():
            yield from _flat(f"{prefix}.{name}" if prefix else name, value)
    else:
        yield prefix, content if isinstance(content, str) else json.dumps(content, ensure_ascii=False)
