"""Addresses in cell files."""

from __future__ import annotations

import re
from typing import Annotated, Any

from stretch_bt.errors import InvalidInput

__all__ = ["Address"]

#: names and IPv4 addresses, or an IPv6 address
_NAME = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]*[A-Za-z0-9])?|[0-9A-Fa-f:]*:[0-9A-Fa-f:.]+")


class _IsAddress:
    """Refuses text that is no address of a machine."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        from pydantic_core import core_schema

        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def check(self, text: str) -> str:
        """Return the text; raises InvalidInput where it is no address."""
        if not _NAME.fullmatch(text):
            raise InvalidInput(f"{text!r} is no address; write a name or an address alone, such as 192.168.1.10")
        return text


Address = Annotated[str, _IsAddress()]
