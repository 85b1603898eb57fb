"""What docs/trust.md says of bounds and ports is what the code has."""

import re
from pathlib import Path

import pytest

from stretch_bt.cli.command_emulate import _check_host
from stretch_bt.hardware.emulators import control
from stretch_bt.source import bounds, compose, read

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "trust.md").read_text("utf-8")


def test_the_bounds_of_files_are_those_of_the_page():
    values = f"{compose.MAX_NODES:,}".replace(",", " ")
    assert (
        f"| {read.MAX_BYTES // 1_000_000} MB, {values} values with anchors expanded, {compose.MAX_DEPTH} levels |"
        in PAGE
    )
    assert f"used together | {bounds.MAX_ARRAYS >> 30} GiB |" in PAGE
    assert bounds.MAX_IMAGE == bounds.MAX_FORM == bounds.MAX_CHUNK
    assert PAGE.count(f"| {bounds.MAX_CHUNK >> 20} MiB |") == 2
    assert f"more than {control._LONGEST} bytes" in PAGE


@pytest.mark.parametrize(
    ("what", "folders"),
    [
        (r"create_server\(|\.bind\(\(|HTTPServer|socketserver", {"hardware/emulators"}),
        (r"import pickle|allow_pickle=True", set()),
    ],
)
def test_only_the_stand_ins_listen_and_nothing_is_unpickled(what, folders):
    package = ROOT / "stretch_bt"
    found = {
        path.parent.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if re.search(what, path.read_text("utf-8"))
    }
    assert found == folders


@pytest.mark.parametrize(
    ("host", "reached"), [("127.0.0.2", False), ("0.0.0.0", True), ("192.168.1.5", True), ("::", True)]
)
def test_an_address_that_other_machines_reach_is_warned_of(host, reached, capsys):
    _check_host(host)
    assert ("can be reached from other machines" in capsys.readouterr().err) == reached
