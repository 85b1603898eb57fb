"""What commands print, and when signals count."""

import os
import signal
from contextlib import nullcontext

import pytest

from stretch_bt.cli.output import emit_json
from stretch_bt.cli.stops import stops
from stretch_bt.run.signals import signals


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
