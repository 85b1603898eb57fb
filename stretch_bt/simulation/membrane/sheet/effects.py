"""Further effects that may act on the sheet; everything is off, and costs nothing, unless it is asked for."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from stretch_bt.errors import InvalidInput
from stretch_bt.source import closest

__all__ = ["Effects", "Mullins"]

DENSITY = 1070.0  # kg/m^3, EcoFlex 00-50
FRICTION = 0.5  # 0.25 to 0.75 is usual for silicone rubber; clean and dry it may exceed 1
_RESIDUAL = 1e-3  # stiffness that wrinkles keep, which makes the tension field solvable


@dataclass(frozen=True, slots=True)
class Mullins:
    """Softening below the largest energy seen (Ogden and Roxburgh 1999): eta = 1 - erf((Wmax - W)/(m + beta Wmax))/r.

    `m` is an energy density over the shear modulus.
    """

    r: float = 2.0
    m: float = 0.05
    beta: float = 0.1

    def __post_init__(self) -> None:
        if not (self.r > 1 and self.m > 0 and self.beta >= 0):
            raise InvalidInput(f"Mullins softening needs r above 1, m above 0 and beta of at least 0, not {self}")


@dataclass(frozen=True, slots=True)
class Effects:
    """Which effects act.

    `wrinkling` relaxes compression to a tension field; `sag` is the density, kg/m^3, of a sheet that hangs towards the
    indenter, as when the hand points down; `bending` gives the sheet the stiffness of a plate; `mullins` softens it
    where it has been stretched further before; `friction` is Coulomb's coefficient between sheet and indenter.

    With friction a press depends on how it was reached: from flat it is pressed straight down at its place and stretch,
    from an earlier press it moves there in a straight line, in increments of at most a hundredth of the gauge.
    """

    wrinkling: bool = False
    sag: float = 0.0
    bending: bool = False
    mullins: Mullins | None = None
    friction: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.sag) and self.sag >= 0):
            raise InvalidInput(f"sag is a density of at least 0 kg/m^3, not {self.sag!r}")
        if not (math.isfinite(self.friction) and self.friction >= 0):
            raise InvalidInput(f"friction is a coefficient of at least 0, not {self.friction!r}")

    @classmethod
    def named(cls, names: Iterable[str]) -> Effects:
        """Return the effects of these names, each with its usual parameters."""
        usual = {"wrinkling": True, "sag": DENSITY, "bending": True, "mullins": Mullins(), "friction": FRICTION}
        listed = isinstance(names, Iterable) and not isinstance(names, str)
        chosen = list(names) if listed else []
        if not listed or not all(isinstance(name, str) for name in chosen):
            raise InvalidInput(f"effects are a list of names, not {names!r}; choose from {', '.join(usual)}")
        for name in chosen:
            if name not in usual:
                near = closest(name, usual)
                hint = f"; did you mean {near}?" if near else ""
                raise InvalidInput(f"{name!r} is no effect; choose from {', '.join(usual)}{hint}")
        return cls(**{name: usual[name] for name in chosen})  # type: ignore[arg-type]

    def law(self) -> tuple[float, float, float, float]:
        """Return the stiffness left to wrinkles and Mullins r, m and beta, as the kernels take them."""
        wrinkles = _RESIDUAL if self.wrinkling else 1.0
        soft = self.mullins
        return (wrinkles, soft.r, soft.m, soft.beta) if soft else (wrinkles, 0.0, 0.0, 0.0)
