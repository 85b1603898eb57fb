"""Short texts of records that hold arrays, so that a test or a shell prints one in a few lines."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

__all__ = ["BriefRepr", "brief"]

#: entries of an array, and of a list, that are shown as they are
FEW_NUMBERS, FEW_ITEMS = 6, 4


class BriefRepr:
    """A dataclass whose repr shows shape, range and count of its arrays, and not their entries."""

    __slots__ = ()

    def __repr__(self) -> str:
        shown = (f"{f.name}={brief(getattr(self, f.name))}" for f in fields(self) if f.repr)  # type: ignore[arg-type]
        return f"{type(self).__name__}({', '.join(shown)})"


def brief(value: Any) -> str:
    """Return a short text of a value: of an array its type, shape, range and how many entries are known."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        some = ", ".join(brief(item) for item in value[:FEW_ITEMS])
        more = f", ... {len(value)} in all" if len(value) > FEW_ITEMS else ""
        return f"[{some}{more}]" if isinstance(value, list) else f"({some}{more})"
    if type(value).__module__.partition(".")[0] == "numpy" and hasattr(value, "dtype"):
        return _of_array(value)
    return repr(value)


def _of_array(array: Any) -> str:
    import numpy as np

    if array.size <= FEW_NUMBERS and array.ndim <= 1:
        return f"[{', '.join(f'{entry:.6g}' for entry in np.atleast_1d(array).tolist())}]"
    what = f"{array.dtype} {array.shape}"
    if array.dtype.kind == "b":
        return f"<{what}, {int(array.sum())} true>"
    if array.dtype.kind not in "iuf" or not array.size:
        return f"<{what}>"
    known = np.isfinite(array)
    if not known.any():
        return f"<{what}, none finite>"
    form = ".4g" if array.dtype.kind == "f" else "d"
    ends = " to ".join(format(end.item(), form) for end in (array[known].min(), array[known].max()))
    return f"<{what}, {ends}" + (">" if known.all() else f", {int(known.sum())} of {array.size} finite>")
