"""record.mcap: JSON and Foxglove messages on topics, one compressed chunk a tick."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, cast

from stretch_bt.runtime.record.plain import dumps
from stretch_bt.runtime.record.readings import SCHEMAS
from stretch_bt.runtime.record.spool import Spool

__all__ = ["FAULT", "FILE", "MARK", "MOTION", "TICK", "UNANSWERED", "Channels", "nanoseconds"]

TICK, MOTION, FAULT, UNANSWERED, WRITE, MARK, FILE = (
    f"stretch.{name}" for name in ("Tick", "Motion", "Fault", "Unanswered", "Write", "Mark", "File")
)


def _schema(title: str, **properties: str) -> dict[str, Any]:
    kinds = {name: {"type": kind} for name, kind in properties.items()}
    return {"title": title, "type": "object", "properties": kinds}


_JSON_SCHEMAS: dict[str, dict[str, Any]] = {
    **SCHEMAS,
    TICK: _schema("A tick begins; time in s", tick="integer", time="number"),
    MOTION: _schema("A motion as a node polled it", device="string", owner="string", state="string"),
    FAULT: _schema("A fault as it reached a node", device="string", kind="string", reason="string"),
    UNANSWERED: _schema("What a device had no answer for", device="string", kind="string", reason="string"),
    MARK: _schema(
        "What is whole so far: bytes of events.jsonl, their CRC-32, and messages before this one",
        **dict.fromkeys(("events", "crc32", "messages"), "integer"),
    ),
    FILE: _schema("Another file of the record, complete", name="string", sha256="string"),
    WRITE: {
        "title": "A value written to a key, SI",
        "type": "object",
        "properties": {"value": {}, "sd": {"type": "number"}, "path": {"type": "string"}},
    },
}


def nanoseconds(time: float) -> int:
    """Return the log time, ns, of a run time, s."""
    return max(0, round(time * 1e9))


class Channels:
    """Writes messages to topics; they reach the disk at `commit`."""

    def __init__(self, path: Path, header: Mapping[str, Any]) -> None:
        from mcap.writer import CompressionType, Writer

        self._spool = Spool(path)
        # frames make up most of it: zstd packs them tighter by half, but takes three times the processor's time of each tick
        self._writer = Writer(cast("IO[bytes]", self._spool), compression=CompressionType.LZ4, enable_data_crcs=True)
        self._writer.start(profile="", library="stretch-bt")
        self._writer.add_metadata("header", {"json": dumps(header).decode()})
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}
        self._messages = 0
        self.now = 0

    def json(self, topic: str, schema: str, fields: Mapping[str, Any], **about: str) -> None:
        """Write a JSON message; `about` says of the whole channel what the reader needs."""
        channel = self._channels.get((topic, schema))
        if channel is None:
            channel = self._new_json(topic, schema, about)
        self._messages += 1
        self._writer.add_message(channel, self.now, dumps(fields), self.now)

    def proto(self, topic: str, message: Any, sequence: int = 0) -> None:
        """Write a protobuf message under a number."""
        schema = message.DESCRIPTOR.full_name
        channel = self._channels.get((topic, schema))
        if channel is None:
            channel = self._new_proto(topic, schema, message)
        self._messages += 1
        self._writer.add_message(channel, self.now, message.SerializeToString(), self.now, sequence)

    def _new_json(self, topic: str, schema: str, about: dict[str, str]) -> int:
        if schema not in self._schemas:
            data = dumps(_JSON_SCHEMAS[schema])
            self._schemas[schema] = self._writer.register_schema(schema, "jsonschema", data)
        return self._new_channel(topic, schema, "json", about)

    def _new_proto(self, topic: str, schema: str, message: Any) -> int:
        from mcap_protobuf.schema import register_schema

        if schema not in self._schemas:
            self._schemas[schema] = register_schema(self._writer, type(message))
        return self._new_channel(topic, schema, "protobuf", {})

    def _new_channel(self, topic: str, schema: str, encoding: str, about: dict[str, str]) -> int:
        channel = self._writer.register_channel(topic, encoding, self._schemas[schema], about)
        self._channels[topic, schema] = channel
        return channel

    def file(self, name: str, content: bytes) -> None:
        """Note the digest of another file of the record."""
        self.json("/files", FILE, {"name": name, "sha256": hashlib.sha256(content).hexdigest()})

    def mark(self, events: int, crc32: int) -> None:
        """Mark how far events.jsonl reaches by now."""
        self.json("/marks", MARK, {"events": events, "crc32": crc32, "messages": self._messages})

    def commit(self, events: int, crc32: int) -> None:
        """Mark how far events.jsonl reaches, end the chunk, and hand everything to the operating system."""
        self.mark(events, crc32)
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._spool.commit()

    def close(self) -> None:
        """Write the index and close."""
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
        finally:
            self._spool.close()

    def abandon(self) -> None:
        """Close without writing anything more."""
        self._spool.abandon()
