"""Errors and values of own nodes whose text cannot be made."""

from typing import Any

import pytest

from stretch_bt.errors import NoAnswer, NodeError, StretchError
from stretch_bt.runtime.replay import replay
from stretch_bt.tree.ports import Behavior, Status
from stretch_bt.tree.registry import node


class Mute(Exception):
    """An exception whose text cannot be made."""

    def __str__(self) -> str:
        raise RuntimeError("no words")

    __repr__ = __str__


class MuteStretchError(Mute, StretchError):
    """One that passes a node as it is."""


class MuteNoAnswer(Mute, NoAnswer):
    """One that fails a node with its reason."""


class Wordless:
    """A value that cannot be shown."""

    def __repr__(self) -> str:
        raise RuntimeError("no words")


@node
class Mutter(Behavior):
    """Breaks in the way and at the place that a test says."""

    error: Any = None
    place = "update"

    def initialise(self) -> None:
        self._break("initialise")

    def update(self) -> Status:
        self._break("update")
        return Wordless() if self.place == "status" else Status.SUCCESS  # type: ignore[return-value]

    def terminate(self, new_status: Status) -> None:
        self._break("terminate")

    def prepare(self) -> None:
        self._break("prepare")

    def _break(self, place: str) -> None:
        if self.place == place:
            raise self.error
        if self.place == "reason" and place == "update":
            self.reason = Wordless()  # type: ignore[assignment]


TREE = "format: stretch-tree/1\ntrees: {main: {sequence: [mutter: {}]}}\n"
BREAKS = [
    ("initialise", Mute(), "Mute"),
    ("update", Mute(), "Mute"),
    ("terminate", Mute(), "Mute"),
    ("prepare", Mute(), "Mute"),
    ("update", ExceptionGroup("several", [Mute()]), "several"),
    ("update", MuteStretchError(), "MuteStretchError"),
    ("terminate", MuteStretchError(), "MuteStretchError"),
    ("status", None, "Wordless"),
    ("reason", None, "Wordless"),
]


@pytest.mark.parametrize(("place", "error", "told"), BREAKS)
def test_a_text_that_cannot_be_made_is_told(
    run: Any, monkeypatch: pytest.MonkeyPatch, place: str, error: Any, told: str
) -> None:
    monkeypatch.setattr(Mutter, "place", place)
    monkeypatch.setattr(Mutter, "error", error)
    try:
        result = run(TREE)
    except NodeError as refused:  # before the first tick
        assert place == "prepare"
        assert str(refused).startswith("main/mutter: ")
        assert told in str(refused)
        return
    assert (result.status, told in result.reason) == ("ERROR", True), result.reason
    assert "main/mutter" in result.reason
    assert replay(result.record).identical


def test_an_answer_without_words_is_a_failure_with_its_reason(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Mutter, "error", MuteNoAnswer("too soft"))
    result = run(TREE)
    assert (result.status, result.reason) == ("FAILURE", "main/mutter: too soft")
