"""A soft sphere whose force is a power of its deflection: a spring, an elastic ball or a gel that relaxes."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.objects.balloon import SECANT_DROP
from stretch_bt.simulation.objects.base import Rough, Specimen
from stretch_bt.simulation.objects.response import Law, Response
from stretch_bt.simulation.objects.round import RoundSpec
from stretch_bt.units import Stiffness, Time
from stretch_bt.within import Within

__all__ = ["SoftSphereObject"]


class SoftSphereObject(RoundSpec):
    """A soft sphere, fixed where it stands, whose force is a power of its deflection: 1 for a spring, 1.5 for an elastic ball."""

    effects: ClassVar[tuple[str, ...]] = ("compliance", "viscosity")

    type: Literal["soft_sphere"]
    stiffness: Annotated[Stiffness, Within(1.0, 1e6, "Stiffness")] = Field(
        description="force over deflection at 1.5 mm, once it has relaxed"
    )
    power: Annotated[float, Within(0.8, 3.0)] = Field(
        default=1.5, description="exponent of its force law, F ~ deflection^power"
    )
    sudden: Annotated[float, Within(0.0, 10.0)] = Field(
        default=0.0, description="additional force of a sudden push, over the relaxed force"
    )
    time: Annotated[Time, Within(1e-3, 1e4, "Time")] = Field(default=2.0, description="time constant of that force")

    @property
    def law(self) -> Law:
        """The force once it has relaxed, by the deflection."""
        return _power(self.stiffness * SECANT_DROP, self.power)

    def gel(self) -> tuple[Law, float] | None:
        """Return the part of its force that relaxes, and the time in which it does, s; None where nothing does."""
        return (_power(self.sudden * self.stiffness * SECANT_DROP, self.power), self.time) if self.sudden else None

    def secant(self, drop: float = SECANT_DROP) -> float:
        """Return force over deflection, N/m, once it has relaxed."""
        return self.law(drop)[0] / drop

    def compliance(self) -> Response:
        """Return how it gives way in equilibrium."""
        from stretch_bt.simulation.balloons.elastic import Elastic

        return Elastic(self.law)

    def rough(self) -> Rough:
        """Return its radius and its stiffness at 1.5 mm."""
        return Rough(self.diameter / 2, self.stiffness, edge=self.diameter / 2)

    def known(self) -> dict[str, float]:
        """Return its radius, m, and its stiffness at 1.5 mm, N/m."""
        return {"radius": self.diameter / 2, "stiffness": self.stiffness}

    def specimen(self, effects: Active) -> Specimen:
        """Return the sphere as it is at the begin of a run, with the effects that are on."""
        return _SoftSpecimen(self, super().specimen(effects).response)


class _SoftSpecimen(Specimen):
    """A soft sphere in a run."""

    def known(self, state: Any, drop: float) -> dict[str, float]:
        """Return its radius, m, and force over deflection, N/m, relaxed, at its deflection, m; without one, that at 1.5 mm."""
        known = super().known(state, drop)
        spec = self.spec
        if self.response is not None and drop > 0 and isinstance(spec, SoftSphereObject):
            known["stiffness"] = spec.secant(drop)
        return known


def _power(force: float, power: float) -> Law:
    """Return the law of a force, N, at 1.5 mm that grows by a power of the deflection, and only pushes."""

    def law(drop: float) -> tuple[float, float]:
        if drop <= 0:
            return 0.0, force / SECANT_DROP if power == 1 else 0.0
        share = drop / SECANT_DROP
        value = force * math.pow(share, power)
        return value, power * value / drop

    return law
