"""JSON from anybody is read, or refused in words."""

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.source.strict_json import read_json


@pytest.mark.parametrize(
    "text", ["[" * 200_000, '{"a":' * 100_000, "{", b"\xff", "", '{"a": NaN}', "[-Infinity]", "-1e999", "1" + "0" * 400]
)
def test_what_is_no_json_is_refused(text) -> None:
    with pytest.raises(InvalidInput, match="it is"):
        read_json(text)


def test_json_is_read() -> None:
    assert read_json('{"a": [1, 2.5, 1e-999, null]}') == {"a": [1, 2.5, 0.0, None]}
