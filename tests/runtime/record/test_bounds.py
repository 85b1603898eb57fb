"""A record takes no more memory than is allowed, whatever the sizes are that it states."""

import tracemalloc

import lz4.frame
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk

from stretch_bt.errors import RecordError
from stretch_bt.runtime.record import RecordReader
from stretch_bt.source.bounds import MAX_CHUNK

SIZE = 4 * MAX_CHUNK
PACK = {"lz4": lz4.frame.compress, "zstd": zstandard.ZstdCompressor().compress}


@pytest.fixture
def record(tmp_path, sample):
    return sample.closed(tmp_path / "r")


@pytest.fixture(scope="module")
def packed():
    return {name: pack(bytes(SIZE)) for name, pack in PACK.items()}


def bomb(record, compression, data, size):
    """Put a chunk before the chunks of a record."""
    chunk = Chunk(compression, data, 0, 0, 0, size)
    out = RecordBuilder()
    chunk.write(out)
    path = record / "record.mcap"
    content = path.read_bytes()
    path.write_bytes(content[:8] + out.end() + content[8:])
    return path


def read(record):
    """Return how much memory the reading of a record took, and the reader or the error."""
    tracemalloc.start()
    try:
        return RecordReader(record), tracemalloc.get_traced_memory()[1]
    except RecordError as error:
        return error, tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("compression", PACK)
def test_a_chunk_that_states_too_much_is_refused(record, packed, compression):
    path = bomb(record, compression, packed[compression], SIZE)
    error, most = read(record)
    [found] = error.diagnostics
    assert found.code == "record-damaged"
    assert str(path) in str(found)
    assert "would take 256 MiB, and at most 64 MiB are read" in found.message
    assert most < MAX_CHUNK // 2


def test_the_size_that_packed_bytes_state_themselves_counts_too(record, packed):
    bomb(record, "zstd", packed["zstd"], 1000)
    error, most = read(record)
    assert [found.code for found in error.diagnostics] == ["record-damaged"]
    assert most < MAX_CHUNK // 2


def test_a_chunk_that_unpacks_to_more_than_it_states_is_refused(record, packed):
    bomb(record, "lz4", packed["lz4"], 1000)
    error, most = read(record)
    assert [found.code for found in error.diagnostics] == ["record-damaged"]
    assert most < MAX_CHUNK // 2


def test_a_record_of_one_part_without_end_is_refused(record):
    path = record / "record.mcap"
    with path.open("r+b") as file:
        file.seek(8)
        file.write(b"\x06" + (SIZE).to_bytes(8, "little"))
        file.truncate(2 * SIZE)
    error, most = read(record)
    assert [found.code for found in error.diagnostics] == ["record-damaged"]
    assert most < MAX_CHUNK // 2
