"""What commands print, and when signals count."""

import io
import json
import os
import signal
import subprocess
import sys
from contextlib import nullcontext

import pytest

from stretch_bt.cli.outlet import answers
from stretch_bt.cli.output import emit_json, print_diagnostics, report_error
from stretch_bt.cli.stops import stops
from stretch_bt.errors import Diagnostic, StretchError
from stretch_bt.runtime.signals import signals


class Speechless(StretchError):
    def __str__(self):
        raise ValueError("no words")


def test_an_error_whose_text_cannot_be_made_is_reported_all_the_same(capsys):
    assert report_error(Speechless()) == 1
    assert "Speechless whose text cannot be made" in capsys.readouterr().err


@pytest.mark.parametrize("last", [False, True])
def test_a_signal_that_comes_while_a_document_is_printed_counts_after_it_unless_that_is_the_last_thing(
    monkeypatch, last
):
    printed = []

    def echo(text, **_):
        os.kill(os.getpid(), signal.SIGINT)
        printed.append(text)

    monkeypatch.setattr("typer.echo", echo)
    monkeypatch.setattr(stops, "way", "raise")
    with signals(stops), nullcontext() if last else pytest.raises(KeyboardInterrupt):
        emit_json({}, last=last)
    assert printed == ["{}"]


def test_what_a_terminal_would_obey_is_shown_escaped_and_marked_where_it_stands(tmp_path, capsys):
    file = tmp_path / "odd.yaml"
    file.write_text("a: 1\nb\x00: \x0c'\x1b[31m'\n")
    print_diagnostics([Diagnostic(str(file), 2, 5, "error", "value", "it is red", length=2)])
    _, line, mark = capsys.readouterr().out.splitlines()
    assert line == "    2 | b\\x00: \\x0c'\\x1b[31m'"
    assert mark == "      | " + " " * len("b\\x00: ") + "^" * len("\\x0c'")


@pytest.mark.parametrize("encoding", ["utf-8", "ascii", "latin-1"])
@pytest.mark.parametrize("document", [{"file": "caf\udce9.yaml", "unit": "µm"}, {"unit": "µm"}, {"unit": "m"}])
def test_a_document_is_whole_json_in_any_encoding(monkeypatch, encoding, document):
    written = io.BytesIO()
    monkeypatch.setattr(answers, "stream", io.TextIOWrapper(written, encoding, write_through=True))
    emit_json(document)
    assert json.loads(written.getvalue().decode(encoding)) == document


@pytest.mark.parametrize("option", ["--json", "--"])
def test_a_path_that_is_no_utf8_is_named_in_findings(option):
    line = [sys.executable, "-m", "stretch_bt", "check", option, b"caf\xe9.yaml"]
    strict = {**os.environ, "PYTHONIOENCODING": "utf-8:strict"}  # as under every locale but C
    ended = subprocess.run(line, env=strict, capture_output=True, timeout=60)
    assert (ended.returncode, ended.stderr) == (2, b"")
    assert rb"caf\udce9.yaml" in ended.stdout
