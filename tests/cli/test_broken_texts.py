"""A run that is refused with an error whose text cannot be made."""

from stretch_bt.cli.command_run import refused
from stretch_bt.errors import StretchError


class BrokenError(StretchError):
    """An error without a text."""

    def __str__(self):
        raise ValueError("no words")


def test_the_reason_is_the_class_of_the_error():
    assert "BrokenError" in refused(BrokenError())["reason"]
