"""Reading a file as text, and as a mapping."""

from __future__ import annotations

from codecs import BOM_UTF8
from pathlib import Path

from stretch_bt.errors import FileError
from stretch_bt.source.bounds import open_file
from stretch_bt.source.compose import parse, refuse
from stretch_bt.source.suggest import did_you_mean
from stretch_bt.source.syntax import lines_of
from stretch_bt.source.values import Map

__all__ = ["load", "read_text", "resolve"]

MAX_BYTES = 1_000_000


def read_text(path: Path, name: str | None = None) -> str:
    """Return the text of a file, or raise FileError that says why it cannot be one."""
    file = name or str(path)
    try:
        if path.is_dir():
            refuse(file, "file-folder", "this is a folder, not a file", "name the YAML file in it")
        if path.exists() and not path.is_file():
            refuse(file, "file-special", "this is a pipe or a device, not a file", "save it as a file first")
        with open_file(path) as stream:
            data = stream.read(MAX_BYTES + 1) or b""
        if len(data) > MAX_BYTES:
            refuse(file, "file-size", f"the file is over {MAX_BYTES // 1_000_000} MB", "split it, and use imports")
    except FileNotFoundError:
        refuse(file, "file-missing", "no such file", "check the path")
    except (OSError, ValueError) as error:
        refuse(file, "file-unreadable", f"the file cannot be read ({error})", "check its permissions")
    plain = data.removeprefix(BOM_UTF8)
    try:
        text = plain.decode()
    except UnicodeDecodeError as error:
        line = len(lines_of(plain[: error.start].decode()))
        place = len(data) - len(plain) + error.start
        refuse(file, "file-binary", f"byte {place} is not UTF-8 text", "save the file as UTF-8 text", line)
    if "\0" in text:
        line = len(lines_of(text[: text.index("\0")]))
        refuse(file, "file-binary", "the file holds NUL bytes, so it is not text", "name a YAML file", line)
    return text


def resolve(given: str | Path, shipped: Path, kind: str) -> Path:
    """Return the file that a path, or the name of a shipped file of this kind, stands for; raises FileError."""
    path = Path(given)
    found = shipped / f"{given}.yaml"
    if path.suffix in (".yaml", ".yml") or len(path.parts) != 1 or path.is_file():
        return path
    if not found.is_file():
        if path.exists():
            return path
        hint = did_you_mean(str(given), (p.stem for p in shipped.glob("*.yaml")))
        refuse(str(given), f"{kind}-unknown", f"there is no shipped {kind} and no file of this name", hint)
    return found


def load(path: Path, name: str | None = None, text: str | None = None) -> Map:
    """Read a file whose top level is a mapping; `name` is its name in messages, `text` is taken for its content."""
    file = name or str(path)
    value = parse(read_text(path, file) if text is None else text, file)
    if not isinstance(value, Map):
        raise FileError([value.mark.error("yaml-top", "the top level is not a mapping", "begin with 'format: ...'")])
    return value
