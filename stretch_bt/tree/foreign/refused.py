"""Why a class gives no node."""

from __future__ import annotations

from stretch_bt.errors import StretchError

__all__ = ["BehaviourRefused"]


class BehaviourRefused(StretchError):
    """A class gives no node; the text says why, `hint` what to do."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.hint = hint
