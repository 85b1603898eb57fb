"""Messages between a driver and its process: frozen dataclasses, written as lines of text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError, with_config

__all__ = ["Answer", "Codec", "End", "Lost", "Message", "Request"]


@with_config(ConfigDict(strict=True, extra="forbid", allow_inf_nan=False))
@dataclass(frozen=True, slots=True)
class Message:
    """What every message is: wrong types, fields that lack or are too many, and numbers that are not finite are refused."""


@dataclass(frozen=True, slots=True)
class Request(Message):
    """To the process: something that is answered by this number."""

    number: int


@dataclass(frozen=True, slots=True)
class Answer(Message):
    """From the process: the result of the request with this number."""

    number: int


@dataclass(frozen=True, slots=True)
class End(Message):
    """To the process: end."""


@dataclass(frozen=True, slots=True)
class Lost(Message):
    """From the process, the last: why it ends, and whether a package is missing."""

    reason: str
    missing: bool


class Codec:
    """Writes messages as lines, and reads them: the name of the class, a space, its fields as JSON.

    Parameters
    ----------
    *kinds
        Classes of the messages, besides `End` and `Lost`; no two have the same name.
    """

    def __init__(self, *kinds: type[Message]) -> None:
        self._adapters: dict[str, TypeAdapter[Any]] = {kind.__name__: TypeAdapter(kind) for kind in (End, Lost, *kinds)}

    def encode(self, message: Message) -> bytes:
        """Return the line of a message, without its end."""
        name = type(message).__name__
        return name.encode() + b" " + self._adapters[name].dump_json(message)

    def decode(self, line: bytes) -> Message:
        """Return the message of a line; raises ValueError for a line that is none."""
        name, _, fields = line.partition(b" ")
        adapter = self._adapters.get(name.decode("ascii", "replace"))
        if adapter is None:
            raise ValueError(f"no message: {line[:40]!r}")
        try:
            message: Message = adapter.validate_json(fields)
        except ValidationError as error:
            first = error.errors()[0]
            place = ".".join(map(str, first["loc"])) or "its fields"
            raise ValueError(f"no message: {line[:40]!r} ({place}: {first['msg']})") from error
        return message
