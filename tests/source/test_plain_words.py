"""Every message of pydantic is given in other words."""

import pytest
from pydantic_core import PydanticKnownError
from pydantic_core._pydantic_core import list_all_errors

from stretch_bt.source.plain_words import in_words

#: errors reported elsewhere, or about no value of a file
ELSEWHERE = ("missing", "extra_forbidden", "default_factory_not_called", "needs_python_object")
ERRORS = [error for error in list_all_errors() if error["type"] not in ELSEWHERE]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: error["type"])
def test_no_error_is_told_in_the_words_of_pydantic(error):
    context = error.get("example_context")
    message = str(PydanticKnownError(error["type"], context).message())
    said, hint = in_words({"type": error["type"], "msg": message, "ctx": context or {}, "input": "watr"}, "'watr'")
    assert hint
    assert not any(word in said + hint for word in ("Input", "discriminator", "tag ", "instance"))
