"""A file of arrays takes no more memory than is allowed, whatever it states; a damaged one is an error that names it."""

import io
import os
import struct
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.lib import format as npy

from stretch_bt.errors import InvalidInput
from stretch_bt.source import arrays
from stretch_bt.source.arrays import array_names, check_arrays, load_array, load_arrays
from stretch_bt.source.bounds import MAX_ARRAYS, hold, read_bytes

MANY = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def header(shape, descr="<u2", version=(1, 0)):
    out = io.BytesIO()
    fields = {"shape": shape, "fortran_order": False, "descr": descr}
    (npy.write_array_header_1_0 if version == (1, 0) else npy.write_array_header_2_0)(out, fields)
    return out.getvalue()


def bomb(path, size, compression=zipfile.ZIP_DEFLATED, name="z.npy"):
    """Write an npz file whose array has `size` bytes of zeros, a part at a time."""
    with zipfile.ZipFile(path, "w", compression) as archive, archive.open(name, "w", force_zip64=True) as entry:
        entry.write(header((size // 2,)))
        for _ in range(size >> 20):
            entry.write(bytes(1 << 20))
    return path


def stated(path, content, size):
    """Write an npz file of one stored entry, whose directory states `size` bytes."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("z.npy", content)
    data = bytearray(path.read_bytes())
    at = data.index(b"PK\1\2")
    data[at + 24 : at + 28] = struct.pack("<I", min(size, 0xFFFFFFFE))
    path.write_bytes(data)
    return path


def taken(read):
    """Return the most memory that a call took, bytes, and the error that it raised."""
    tracemalloc.start()
    try:
        read()
    except InvalidInput as error:
        return tracemalloc.get_traced_memory()[1], str(error)
    finally:
        tracemalloc.stop()
    return 0, ""


def test_what_numpy_writes_is_read(tmp_path):
    kept = {"a": np.arange(6.0).reshape(2, 3), "b": np.zeros((2, 2), np.uint16, order="F"), "c": np.array(3)}
    for save in (np.savez, np.savez_compressed):
        save(tmp_path / "x.npz", **kept)
        assert sorted(array_names(tmp_path / "x.npz")) == ["a", "b", "c"]
        found = load_arrays(tmp_path / "x.npz", kept)
        assert all(np.array_equal(found[name], kept[name]) for name in kept)
    np.save(tmp_path / "x.npy", kept["a"])
    assert np.array_equal(load_array(tmp_path / "x.npy"), kept["a"])


def test_an_array_that_unpacks_to_too_much_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr(arrays, "MAX_ARRAYS", 8 << 20)
    path = bomb(tmp_path / "bomb.npz", 64 << 20)
    assert path.stat().st_size < 100_000
    for read in (check_arrays, load_arrays):
        most, said = taken(lambda read=read: read(path, ["z"]))
        assert most < 1 << 20
        assert str(path) in said
        assert "64 MiB, and at most 8 MiB are read; split the recording" in said


def test_arrays_that_are_too_large_together_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(arrays, "MAX_ARRAYS", 1 << 20)
    np.savez(tmp_path / "x.npz", a=np.zeros(100_000), b=np.zeros(100_000))
    assert load_arrays(tmp_path / "x.npz", ["a"])["a"].shape == (100_000,)
    with pytest.raises(InvalidInput, match="with array 'b' would take"):
        load_arrays(tmp_path / "x.npz", ["a", "b"])


@pytest.mark.parametrize("compression", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_ways_to_pack_that_cannot_be_bounded_are_refused(tmp_path, compression):
    path = bomb(tmp_path / "x.npz", 1 << 20, compression)
    with pytest.raises(InvalidInput, match=r"x\.npz: array 'z' is packed in a way that numpy does not use"):
        load_arrays(path, ["z"])


@MANY
@given(
    shape=st.lists(st.one_of(st.integers(-3, 4), st.integers(0, 1 << 70)), max_size=6).map(tuple),
    descr=st.sampled_from(["<u2", "<f8", "|O", "|V0", "|S9", [("a", "<f8", (10**9,))], "(99999999,)<f8", "nonsense"]),
    version=st.sampled_from([(1, 0), (2, 0)]),
    size=st.one_of(st.none(), st.integers(0, 1 << 33)),
    content=st.binary(max_size=64),
)
def test_no_header_takes_more_than_the_bound(tmp_path, monkeypatch, shape, descr, version, size, content):
    monkeypatch.setattr(arrays, "MAX_ARRAYS", 1 << 20)
    whole = header(shape, descr, version) + content
    (tmp_path / "x.npy").write_bytes(whole)
    path = stated(tmp_path / "x.npz", whole, len(whole) if size is None else size)
    for file, read in (
        (tmp_path / "x.npy", lambda: load_array(tmp_path / "x.npy", 1 << 20)),
        (path, lambda: load_arrays(path, ["z"])),
    ):
        most, said = taken(read)
        assert most < 4 << 20
        assert not said or str(file) in said


@MANY
@given(data=st.data())
def test_damage_is_an_error_that_names_the_file_or_is_harmless(tmp_path, data):
    np.savez_compressed(tmp_path / "x.npz", z=np.arange(300.0), t=np.arange(5))
    np.save(tmp_path / "x.npy", np.arange(30.0))
    for name, read in (("x.npz", lambda path: load_arrays(path, array_names(path))), ("x.npy", load_array)):
        path: Path = tmp_path / name
        content = bytearray(path.read_bytes())
        if data.draw(st.booleans()):
            del content[data.draw(st.integers(0, len(content))) :]
        for _ in range(data.draw(st.integers(0, 3)) if content else 0):
            content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
        path.write_bytes(content)
        most, said = taken(lambda path=path, read=read: read(path))
        assert most < 4 << 20
        assert not said or name in said


@pytest.mark.parametrize("place", [-6, -5, -4, -3])  # the bytes that say where the table begins
def test_a_table_of_contents_that_points_before_the_file_is_damage(tmp_path, place):
    path = tmp_path / "x.npz"
    np.savez_compressed(path, z=np.arange(300.0))
    content = bytearray(path.read_bytes())
    content[place] = 0xFF
    path.write_bytes(content)
    with pytest.raises(InvalidInput, match=r"x\.npz is not an npz file"):
        load_arrays(path, array_names(path))


def test_a_file_without_end_is_left(tmp_path):
    with pytest.raises(OSError, match="a pipe or a device"):
        read_bytes(Path("/dev/zero"), 1024)


def test_the_error_says_what_it_would_take_the_bound_and_what_to_do():
    hold("x.npz", MAX_ARRAYS, MAX_ARRAYS, "")
    with pytest.raises(InvalidInput, match=r"x\.npz would take 23 GiB, and at most 4 GiB are read; split it"):
        hold("x.npz", 23 << 30, MAX_ARRAYS, "split it")


@pytest.mark.parametrize(
    "content", [np.array(["a", "b"]), np.array([b"a"]), np.array([1j]), np.array(["2026-01-01"], "M8[D]")]
)
def test_only_numbers_are_read(tmp_path: Path, content: np.ndarray) -> None:
    np.savez(tmp_path / "a.npz", a=content)
    np.save(tmp_path / "a.npy", content)
    for call in (lambda: check_arrays(tmp_path / "a.npz", ["a"]), lambda: load_array(tmp_path / "a.npy")):
        with pytest.raises(InvalidInput, match="not numbers"):
            call()


@pytest.mark.parametrize(
    "read",
    [
        read_bytes,
        load_array,
        array_names,
        lambda path: load_arrays(path, ["a"]),
        lambda path: check_arrays(path, ["a"]),
    ],
)
def test_nobody_waits_for_a_pipe(tmp_path: Path, read) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="a pipe or a device, not a file"):
        read(tmp_path / "pipe")
    with pytest.raises(OSError, match="a pipe or a device, not a file"):
        read(Path("/dev/zero"))
