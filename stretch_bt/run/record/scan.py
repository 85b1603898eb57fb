"""Reading record.mcap chunk by chunk, as far as it goes: a killed process leaves a file without an end."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

__all__ = ["ChunkFile"]

MAGIC = b"\x89MCAP0\r\n"
HEAD = 9  # opcode and length


class ChunkFile:
    """The chunks of an MCAP file; after an iteration `whole` says whether it came to the end and found no damage."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.whole = False

    def __iter__(self) -> Iterator[tuple[int, list[Any]]]:
        """Yield the offset and the records of each chunk, up to the first that is cut off or damaged."""
        from mcap.exceptions import McapError
        from mcap.opcode import Opcode
        from zstandard import ZstdError

        # RuntimeError is what lz4 raises
        broken = (McapError, ZstdError, RuntimeError, MemoryError, ValueError, OverflowError, struct.error)
        with self.path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                return
            check, sound = zlib.crc32(MAGIC), False
            for offset, head, content in _parts(file, self.path.stat().st_size):
                if head[0] == Opcode.CHUNK:
                    try:
                        records = _records(content)
                    except broken:
                        return
                    yield offset, records
                elif head[0] == Opcode.DATA_END:
                    sound = content == check.to_bytes(4, "little")
                elif head[0] == Opcode.FOOTER:
                    self.whole = sound and file.read() == MAGIC
                check = zlib.crc32(content, zlib.crc32(head, check))

    def at(self, offset: int) -> list[Any]:
        """Return the records of the chunk at an offset."""
        with self.path.open("rb") as file:
            file.seek(offset)
            return _records(file.read(_length(file.read(HEAD))))


def _length(head: bytes) -> int:
    return int.from_bytes(head[1:], "little")


def _parts(file: BinaryIO, size: int) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield the offset, head and content of each record that lies in the file as a whole."""
    offset = file.tell()
    while len(head := file.read(HEAD)) == HEAD:
        end = offset + HEAD + _length(head)
        if end > size:
            return
        yield offset, head, file.read(_length(head))
        offset = end


def _records(chunk: bytes) -> list[Any]:
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk
    from mcap.stream_reader import breakup_chunk

    return breakup_chunk(Chunk.read(ReadDataStream(io.BytesIO(chunk))), validate_crc=True)
