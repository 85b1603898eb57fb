"""How the parts of a task end."""

from __future__ import annotations

from hypothesis import strategies as st

__all__ = ["ENDS"]

#: status of a mocked place, and after how many milliseconds
ENDS = st.tuples(st.sampled_from(["success", "failure", "running"]), st.integers(0, 500))
