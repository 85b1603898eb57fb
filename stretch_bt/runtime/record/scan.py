"""Reading record.mcap chunk by chunk, as far as it goes: a killed process leaves a file without an end."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO

from stretch_bt.errors import InvalidInput
from stretch_bt.source.bounds import MAX_CHUNK, hold

__all__ = ["ChunkFile"]

MAGIC = b"\x89MCAP0\r\n"
HEAD = 9  # opcode and length
CRC = 4
_REMEDY = "no recorder writes one as large: record the run again"


class ChunkFile:
    """The chunks of an MCAP file.

    Attributes
    ----------
    end : int
        After an iteration, the byte up to which the file could be read.
    whole : bool
        After an iteration, whether it came to the end of the file that a writer puts there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.end = 0
        self.whole = False

    def __iter__(self) -> Iterator[tuple[int, list[Any]]]:
        """Yield the offset and the records of each chunk, up to where the file is cut off.

        Raises
        ------
        InvalidInput
            A byte that was read is not as it was written, or a chunk would take more than `MAX_CHUNK`; the text says
            where.
        """
        from mcap.opcode import Opcode

        with self.path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                return
            check = zlib.crc32(MAGIC)
            for offset, head, content in _parts(file, self.path.stat().st_size):
                if head[0] == Opcode.CHUNK:
                    yield offset, self._records(offset, content)
                elif head[0] == Opcode.DATA_END:
                    _hold_sum(content, check, offset)
                    check = 0  # a second sum begins here
                elif head[0] == Opcode.FOOTER:
                    _hold_sum(content[-CRC:], zlib.crc32(content[:-CRC], zlib.crc32(head, check)), offset)
                    self.whole = file.read() == MAGIC
                if head[0] != Opcode.DATA_END:
                    check = zlib.crc32(content, zlib.crc32(head, check))
                self.end = offset + HEAD + len(content)

    def at(self, offset: int) -> list[Any]:
        """Return the records of the chunk at an offset."""
        with self.path.open("rb") as file:
            file.seek(offset)
            return self._records(offset, file.read(_length(file.read(HEAD))))

    def _records(self, offset: int, content: bytes) -> list[Any]:
        from mcap.exceptions import McapError
        from zstandard import ZstdError

        # RuntimeError is what lz4 raises
        broken = (McapError, ZstdError, RuntimeError, MemoryError, ValueError, OverflowError, struct.error)
        try:
            return _records(content, f"its chunk at byte {offset}")
        except InvalidInput:
            raise
        except broken as error:
            raise InvalidInput(f"its chunk at byte {offset} is not as it was written: {error}") from error


def _hold_sum(stated: bytes, found: int, offset: int) -> None:
    if stated not in (found.to_bytes(CRC, "little"), bytes(CRC)):  # zero says that there is none
        raise InvalidInput(f"its checksum at byte {offset} does not hold: a byte before that is not as it was written")


def _length(head: bytes) -> int:
    return int.from_bytes(head[1:], "little")


def _parts(file: BinaryIO, size: int) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield the offset, head and content of each record that lies in the file as a whole."""
    offset = file.tell()
    while len(head := file.read(HEAD)) == HEAD:
        end = offset + HEAD + _length(head)
        if end > size:
            return
        hold(f"its part at byte {offset}", _length(head), MAX_CHUNK, _REMEDY)
        yield offset, head, file.read(_length(head))
        offset = end


def _records(chunk: bytes, name: str) -> list[Any]:
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk
    from mcap.stream_reader import breakup_chunk

    packed = Chunk.read(ReadDataStream(io.BytesIO(chunk)))
    unpacked = replace(packed, compression="", data=_unpacked(packed, name))
    return breakup_chunk(unpacked, validate_crc=True)


def _unpacked(chunk: Any, name: str) -> bytes:
    """Return the content of a chunk; its unpacker is given a limit, whatever size the packed bytes state."""
    from lz4.frame import LZ4FrameDecompressor
    from zstandard import ZstdDecompressor, frame_content_size

    size = chunk.uncompressed_size
    if chunk.compression == "zstd":
        size = max(size, frame_content_size(chunk.data))
    hold(name, size, MAX_CHUNK, _REMEDY)
    data = chunk.data
    if chunk.compression == "lz4":
        data = LZ4FrameDecompressor().decompress(data, max_length=size)
    elif chunk.compression == "zstd":
        data = ZstdDecompressor().decompress(data, max_output_size=size)
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes unpacks to {len(data)}")
    return bytes(data)
