"""Where to begin pressing at another stretch."""

from __future__ import annotations

from stretch_bt.model.force.force_model import ForceModel, check_model

__all__ = ["next_indentation"]


def next_indentation(model: ForceModel, radius: float, stretch: float, force: float) -> float:
    """Return the depth, m, at the next stretch at which the force has not fallen.

    Parameters
    ----------
    model
        The hand's force law.
    radius
        Radius of the sphere, m.
    stretch
        The next stretch, m.
    force
        The force of the last press, N; the depth is where `model.predict` gives it again.

    Raises
    ------
    NoEquilibrium
        No depth that the model covers gives the force.
    """
    check_model(model)
    return model.depth_for(radius, stretch, force)
