"""Workers of a scheduler: each is asked once, and one that cannot run items is named."""

import pytest

from stretch_bt.errors import InvalidInput, StretchError
from stretch_bt.sweep import crew
from stretch_bt.sweep.crew import Crew
from stretch_bt.sweep.package_digest import package_digest


class Client:
    """Workers that answer what the test says, or what they are asked."""

    def __init__(self):
        self.answers, self.asked, self.limit = {}, [], None

    def nthreads(self):
        return dict.fromkeys(self.answers, 1)

    def run(self, function, question, *, workers, on_error, callback_timeout):
        self.asked += workers
        self.limit = callback_timeout
        found = {name: self.answers[name] for name in workers}
        if any(answer is TimeoutError for answer in found.values()):
            raise TimeoutError
        return {name: function(question) if answer is None else answer for name, answer in found.items()}


@pytest.fixture
def client():
    return Client()


def test_each_worker_is_asked_once_also_one_that_joins_later(client):
    found = Crew(client, ask=True)
    client.answers = {"a": None, "b": package_digest(), "leaving": OSError("gone")}
    assert [found.look(), found.look()] == [3, 3]
    client.answers["c"] = None
    assert found.look() == 4
    assert sorted(name for name in client.asked if name != "leaving") == ["a", "b", "c"]
    assert client.limit == crew.PATIENCE


@pytest.mark.parametrize(
    ("answer", "kind", "said"),
    [
        ("another", InvalidInput, "the worker late has another stretch_bt .* go on with --resume"),
        (
            ModuleNotFoundError("No module named 'stretch_bt'"),
            StretchError,
            r"cannot run an item \(late: .*No module named 'stretch_bt'\); see that each has stretch-bt installed",
        ),
        (TimeoutError, StretchError, r"cannot run an item \(no answer from late within 5 minutes\)"),
    ],
)
def test_a_worker_that_cannot_run_items_is_named(client, answer, kind, said):
    """Without the package it broke without a word, and the sweep waited for ever."""
    found = Crew(client, ask=True)
    client.answers = {"a": None}
    found.look()
    client.answers["late"] = answer
    with pytest.raises(kind, match=said):
        found.look()


def test_workers_of_our_own_are_not_asked(client):
    client.answers = {"a": "another"}
    assert Crew(client, ask=False).look() == 1
    assert client.asked == []
