"""Errors of drivers whose text cannot be made: a reason is reported all the same."""

from types import SimpleNamespace

import pytest

from stretch_bt.errors import StretchError
from stretch_bt.hardware import keeper
from stretch_bt.hardware.supervisor import Supervisor


class BrokenOSError(OSError):
    """An error of the system without a text."""

    def __str__(self):
        raise ValueError("no words")


class BrokenError(StretchError):
    """An error of the package without a text."""

    def __str__(self):
        raise ValueError("no words")


@pytest.mark.parametrize("error", [BrokenOSError(), BrokenError()])
def test_a_keeper_tells_its_driver_the_class(error):
    sent = []
    keeper._tell(SimpleNamespace(send=sent.append), error, "{}")
    assert type(error).__name__ in sent[0].reason


@pytest.mark.parametrize("error", [BrokenOSError(), BrokenError()])
def test_a_supervisor_tells_the_class(error):
    assert type(error).__name__ in Supervisor._why(SimpleNamespace(_child=None), error)
