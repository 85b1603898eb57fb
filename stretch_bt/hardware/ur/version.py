"""Which controllers are supported."""

from __future__ import annotations

import re

from stretch_bt.hardware.ur.rtde import Rtde

__all__ = ["LOWER_ONLY", "POLYSCOPE_X", "TOO_NEW", "has_model", "is_polyscope_x", "major_minor"]

#: from this major version on a controller runs PolyScope X, which has no dashboard
POLYSCOPE_X = 10
#: from this version on ur-rtde 1.6 uses the lower registers, whatever it is asked for
LOWER_ONLY = (5, 23)
#: from these versions on, by major version, a dashboard is asked for the model
_MODEL = {3: (3, 12), 5: (5, 6)}
TOO_NEW = (
    "this controller runs PolyScope X, which is not supported; use a UR5 with PolyScope 3 or a UR5e with PolyScope 5"
)


def major_minor(answer: str) -> tuple[int, int]:
    """Return the major and the minor version in the answer to `PolyscopeVersion`, 0 for those that it does not hold."""
    major, minor = [int(number) for number in (*re.findall(r"\d+", answer), 0, 0)[:2]]
    return major, minor


def has_model(version: tuple[int, int]) -> bool:
    """Return whether a dashboard of a version says which model it is of; none of PolyScope 3 or 5 before that, any other one."""
    return version >= _MODEL.get(version[0], (0, 0))


def is_polyscope_x(host: str) -> bool:
    """Return whether a controller says by RTDE that it runs PolyScope X; False where it does not answer."""
    try:
        with Rtde(host) as controller:
            return controller.version()[0] >= POLYSCOPE_X
    except OSError:
        return False
