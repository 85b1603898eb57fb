"""Whatever is given instead of a file is refused with the reason; nothing is waited for and nothing expands without end."""

import os
import sys
from pathlib import Path

import pytest

from stretch_bt import check
from stretch_bt.errors import FileError
from stretch_bt.source import load, read_text

HEAD = "format: stretch-tree/1\n"


def laughs(levels: int, width: int) -> str:
    rows = [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * width)}]" for i in range(1, levels)]
    return "\n".join([HEAD + "a0: &a0 [x]", *rows])


#: name -> (what the file holds, code, part of the message)
CONTENTS = {
    "empty": (b"", "file-empty", "empty"),
    "only comments": (b"\n# nothing\n\n", "file-empty", "empty"),
    "a picture": (b"\x89PNG\r\n\x1a\n\0\0", "file-binary", "not UTF-8"),
    "NUL bytes": (b"format: \0", "file-binary", "NUL"),
    "latin-1": ("doc: Kraft in µN\n".encode("latin-1"), "file-binary", "not UTF-8"),
    "a mark of byte order and a bad byte": (b"\xef\xbb\xbfa\xff", "file-binary", "byte 4 is not UTF-8"),
    "the mark, and a cut within a character": (b"\xef\xbb\xbfa\xc3\xa9bc\xff", "file-binary", "byte 8 is not UTF-8"),
    "UTF-16": (HEAD.encode("utf-16"), "file-binary", "not UTF-8"),
    "50 MB": (b"a: b\n" * 10_000_000, "file-size", "over 1 MB"),
    "billion laughs": (laughs(20, 9).encode(), "yaml-size", "anchors expanded"),
    "laughs in mappings": (
        (
            HEAD + "a0: &a0 {k: x}\n" + "".join(f"a{i}: &a{i} {{p: *a{i - 1}, q: *a{i - 1}}}\n" for i in range(1, 40))
        ).encode(),
        "yaml-size",
        "anchors expanded",
    ),
    "an alias as a key": (b"a: &a x\n? *a\n: 1\n", "yaml-key", "plain text"),
    "a sequence as a key": (b"? [a]\n: 1\n", "yaml-key", "plain text"),
    "an anchor on a key": (b"b: 1\n&a depth: 5 mm\nc: *a\n", "yaml-key", "the anchor &a stands on a key"),
    "a tag on a key": (b"b: {!!str depth: 5 mm}\n", "yaml-tag", "no meaning"),
    "an empty tag on a key": (b"! a: 1\n", "yaml-tag", "no meaning"),
    "an anchor inside itself": (b"a: &a [*a]\n", "yaml-anchor", "no anchor"),
    "brackets without end": (HEAD.encode() + b"a: " + b"[" * 400_000, "yaml-depth", "deeper"),
    "dashes without end": (HEAD.encode() + b"a:\n" + b"- " * 200_000, "yaml-depth", "deeper"),
    "a quote without end": (HEAD.encode() + b'doc: "' + b"x" * 900_000, "yaml-syntax", "never closed"),
    "a line without end": (HEAD.encode() + b"doc: " + b"x" * 900_000, "trees-missing", "no trees"),
    "many keys": (HEAD.encode() + b"".join(b"k%d: 1\n" % i for i in range(30_000)), "yaml-size", "values"),
    "a control character": (HEAD.encode() + b"doc: \x07", "yaml-syntax", "forbidden"),
}


@pytest.mark.parametrize("name", CONTENTS)
def test_what_is_no_file_of_ours_is_refused(name: str, tmp_path: Path) -> None:
    content, code, said = CONTENTS[name]
    path = tmp_path / "tree.yaml"
    path.write_bytes(content)
    [found] = check([path])
    assert (found.file, found.code) == (str(path), code)
    assert said in found.message
    assert found.hint
    assert len(str(found)) < 2000


def pipe(path: Path) -> Path:
    os.mkfifo(path)
    return path


def link_to_itself(path: Path) -> Path:
    path.symlink_to(path)
    return path


def folder(path: Path) -> Path:
    path.mkdir()
    return path


PLACES = {
    "folder": (folder, "file-folder"),
    "pipe": (pipe, "file-special"),
    "endless device": (lambda _: Path("/dev/zero"), "file-special"),
    "nothing there": (lambda path: path, "file-missing"),
    "link to itself": (link_to_itself, "file-unreadable"),
    "name with a NUL": (lambda _: Path("a\0b.yaml"), "file-unreadable"),
    "name too long": (lambda path: path.with_name("x" * 5000 + ".yaml"), "file-unreadable"),
}


@pytest.mark.skipif(sys.platform == "win32", reason="pipes and devices are named otherwise on Windows")
@pytest.mark.parametrize("name", PLACES)
def test_what_is_no_file_is_refused_without_waiting(name: str, tmp_path: Path) -> None:
    make, code = PLACES[name]
    [found] = check([make(tmp_path / "tree.yaml")])
    assert found.code == code
    assert found.hint


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read every file")
def test_a_file_without_permission_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "tree.yaml"
    path.write_text(HEAD)
    path.chmod(0)
    [found] = check([path])
    assert found.code == "file-unreadable"


def test_a_byte_order_mark_and_windows_lines_change_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes("\ufeffa: 1\r\nb:\r\n  - c: x\r\n".encode())
    root = load(path)
    assert root.plain() == {"a": 1, "b": [{"c": "x"}]}
    inner = root.get("b")
    assert inner is not None
    assert (inner.items[0].key("c").mark.line, inner.items[0].key("c").mark.column) == (3, 5)


def test_messages_call_a_file_as_it_was_given(tmp_path: Path) -> None:
    with pytest.raises(FileError) as caught:
        read_text(tmp_path / "a.yaml", "my tree")
    assert caught.value.diagnostics[0].file == "my tree"
