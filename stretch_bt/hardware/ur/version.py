"""Which controllers are supported."""

from __future__ import annotations

from stretch_bt.hardware.ur.rtde import Rtde

__all__ = ["LOWER_ONLY", "POLYSCOPE_X", "TOO_NEW", "is_polyscope_x"]

#: from this major version on a controller runs PolyScope X, which has no dashboard
POLYSCOPE_X = 10
#: from this version on ur-rtde 1.6 uses the lower registers, whatever it is asked for
LOWER_ONLY = (5, 23)
TOO_NEW = (
    "this controller runs PolyScope X, which is not supported; use a UR5 with PolyScope 3 or a UR5e with PolyScope 5"
)


def is_polyscope_x(host: str) -> bool:
    """Return whether a controller says by RTDE that it runs PolyScope X; False where it does not answer."""
    try:
        with Rtde(host) as controller:
            return controller.version()[0] >= POLYSCOPE_X
    except OSError:
        return False
