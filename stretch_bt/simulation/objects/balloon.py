"""A filled balloon that stands out of a cup as a hemisphere, and gives way under the hand."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.quantity_text import format_quantity
from stretch_bt.simulation.balloons.cap import HAND
from stretch_bt.simulation.balloons.fills import Air, AnyFill, Pudding
from stretch_bt.simulation.balloons.laws import hertz, linear, no_force, scaled, together
from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.objects.base import HertzForm, ObjectSpec, Rough, Specimen, Standing
from stretch_bt.simulation.objects.response import Law, Response
from stretch_bt.units import KINDS, Length, Pressure
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.balloons.table import TabulatedCap
    from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["SECANT_DROP", "BalloonObject", "BalloonSpecimen"]

#: the drop at which the stiffness of a balloon is given, m: the same as in palpation
SECANT_DROP = 1.5e-3
_SLACK = 1.0  # Pa, below which the skin is taken for slack
_SETTLED = 1e6  # s
#: modulus of the hand times radius over pressure, at least, and softness of a gas, at most, for which the table is meant
_FIRMEST, _SOFTEST = 0.7, 0.2
_WIDEST = 1.5  # largest radius of a flattened top over its own


class BalloonObject(ObjectSpec):
    """A filled balloon that stands out of a cup as a hemisphere, and gives way under the hand."""

    effects: ClassVar[tuple[str, ...]] = (
        "compliance",
        "gas_compressibility",
        "latex_softening",
        "granular_hysteresis",
        "viscosity",
        "flattening",
    )

    type: Literal["balloon"]
    diameter: Annotated[Length, Within(0.020, 0.080, "Length")] = Field(description="diameter where it leaves the cup")
    pressure: Annotated[Pressure, Within(0.0, 10e3, "Pressure")] = Field(
        description="pressure of the fill over the air around; the skin's tension follows from it"
    )
    fill: AnyFill = Field(description="air, water, pudding or seeds")
    model: Literal["linear", "table", "axisymmetric"] = Field(
        default="table",
        description="source of the skin's force: a spring, the table that the solver made, or the solver itself",
    )
    elements: Annotated[int, Field(ge=8, le=192)] = Field(default=48, description="number of elements of the solver")

    @model_validator(mode="after")
    def _within_the_table(self) -> BalloonObject:
        most = HAND * self.radius / _FIRMEST
        if self.fill.by_skin and self.pressure > most:
            told = format_quantity(most, KINDS["Pressure"])
            raise InvalidInput(
                f"a balloon so small and hard sinks into the hand up to its rim; use a pressure of at most {told}"
            )
        if isinstance(self.fill, Air) and self.fill.softness(self.radius, self.pressure) > _SOFTEST:
            raise InvalidInput(
                "with so much air below the rim the pressure hardly rises; use less of it, or less pressure"
            )
        return self

    @property
    def radius(self) -> float:
        """Its radius, m."""
        return self.diameter / 2

    @property
    def top(self) -> float:
        """World height of its undeformed top, m; `base` is where it leaves the cup."""
        return self.base + self.radius

    @property
    def reach(self) -> float:
        """Its radius, m."""
        return self.radius

    @property
    def hertz(self) -> HertzForm:
        """A sphere."""
        return HertzForm("sphere", self.radius)

    def body(self) -> Sphere:
        """Return a hemisphere on a shank."""
        return self.flattened(0.0)

    def flattened(self, drop: float) -> Sphere:
        """Return the sphere that its top resembles, as far as the hand touches it, after a drop, m."""
        from stretch_bt.simulation.membrane.indenters.sphere import Sphere

        return Sphere(2 * self.top_radius(drop))

    def top_radius(self, drop: float) -> float:
        """Return the radius of the flattened top after a drop, m.

        A skin has the table's. Grains have the radius of two elastic bodies in contact, 1 / R - 1 / R' = drop / a^2 with the
        contact radius a^2 = R (drop + depth) and the depth to which the hand, as a foundation, is entered by the same force.
        """
        if drop <= 0:
            return self.radius
        if self.fill.by_skin:
            grown = math.inf if self.tabulated is None else 1 + self.tabulated.flattening(drop / self.radius)[0]
        else:
            depth = math.sqrt(self.law(drop)[0] / (math.pi * HAND * self.radius))
            grown = 1 + drop / depth if depth > 0 else math.inf
        return self.radius * min(grown, _WIDEST)

    @property
    def tabulated(self) -> TabulatedCap | None:
        """The skin in its own units, None while it is slack."""
        return _tabulated(HAND * self.radius / self.pressure) if self.pressure >= _SLACK else None

    @property
    def limit(self) -> float:
        """The drop at which the hand would reach the rim of the cup, m, or at which the balloon is flat."""
        if self.tabulated is None or not self.fill.by_skin:
            return self.radius
        return self.radius * self.tabulated.limit

    @property
    def skin(self) -> Law:
        """The force of the skin around a fill that keeps its volume, by the drop of the top."""
        if self.tabulated is None or not self.fill.by_skin:
            return no_force
        law = scaled(self.tabulated.force, self.pressure * self.radius**2, self.radius)
        if self.model == "axisymmetric":
            return _solved(self.radius, self.pressure, self.elements, self.limit)
        return linear(law(SECANT_DROP)[0] / SECANT_DROP) if self.model == "linear" else law

    @property
    def law(self) -> Law:
        """The force of skin and fill in equilibrium, on first loading."""
        inside = self.fill.body(self.radius, self.pressure)
        if self.model == "linear":
            inside = linear(inside(SECANT_DROP)[0] / SECANT_DROP)
        return together(self.skin, inside) if self.fill.by_skin else inside

    def squeezed(self) -> Law:
        """Return the loss by a gas of the force of a fill that keeps its volume: F beta s / (1 + beta s)."""
        if self.tabulated is None or not isinstance(self.fill, Air):
            return no_force
        beta, skin, radius = self.fill.softness(self.radius, self.pressure), self.skin, self.radius
        yields = self.tabulated.yields

        def law(drop: float) -> tuple[float, float]:
            (force, slope), (s, by) = skin(drop), yields(drop / radius)
            part = beta * s / (1 + beta * s)
            return force * part, slope * part + force * beta * by / radius / (1 + beta * s) ** 2

        return law

    def gel(self) -> tuple[Law, float] | None:
        """Return the part of a gel's force that relaxes, and the time in which it does, s; None without a gel."""
        return (hertz(self.fill.sudden, self.radius), self.fill.time) if isinstance(self.fill, Pudding) else None

    def secant(self, drop: float = SECANT_DROP) -> float:
        """Return force over drop, N/m, in equilibrium on first loading."""
        return self.law(drop)[0] / drop

    def compliance(self) -> Response:
        """Return how it gives way in equilibrium."""
        from stretch_bt.simulation.balloons.elastic import Elastic

        return Elastic(self.law)

    def rough(self) -> Rough:
        """Return its radius and its stiffness at 1.5 mm."""
        return Rough(self.radius, max(self.secant(), 1e-6), edge=self.radius)

    def known(self) -> dict[str, float]:
        """Return its radius, m, and its stiffness at 1.5 mm, N/m, in equilibrium on first loading."""
        return {"radius": self.radius, "stiffness": self.secant()}

    def specimen(self, effects: Active) -> Specimen:
        """Return the balloon as it is at the begin of a run, with the effects that are on."""
        return BalloonSpecimen(self, super().specimen(effects).response, flattens="flattening" in effects)


class BalloonSpecimen(Specimen):
    """A balloon in a run; `flattens` says whether its top flattens as it drops, or keeps the radius of the balloon."""

    def __init__(self, spec: BalloonObject, response: Response | None, *, flattens: bool) -> None:
        super().__init__(spec, response)
        self.balloon = spec
        self.flattens = flattens

    def standing(self, state: Any, drop: float) -> Standing:
        """Return the body that the membrane meets after a drop of its top, m.

        Raises
        ------
        NoEquilibrium
            The hand would reach the rim of the cup, or press the balloon flat.
        """
        spec = self.balloon
        if drop >= spec.limit:
            raise NoEquilibrium(
                f"a drop of {drop * 1e3:.3g} mm is past {spec.limit * 1e3:.3g} mm, where the hand reaches the rim of the cup"
            )
        place, body = spec.position, spec.flattened(drop) if self.flattens else spec.body()
        return Standing(body, place.x, place.y, spec.heading, spec.top - drop, varies=self.flattens)

    def form(self, standing: Standing) -> HertzForm | None:
        """Return the sphere that stands in for it, of the radius that its top has."""
        from stretch_bt.simulation.membrane.indenters.sphere import Sphere

        if not (self.flattens and isinstance(standing.body, Sphere)):
            return super().form(standing)
        return HertzForm("sphere", standing.body.diameter / 2)

    def known(self, state: Any, drop: float) -> dict[str, float]:
        """Return the radius of its top, m, and force over drop, N/m, settled and on first loading, at its drop.

        Without a drop that at 1.5 mm.
        """
        known = super().known(state, drop)
        if self.flattens:
            known["radius"] = self.balloon.flattened(drop).diameter / 2
        if self.response is not None:
            at = drop if drop > 0 else SECANT_DROP
            known["stiffness"] = self.response.law(self.response.start(), _SETTLED)(at)[0] / at
        return known


@lru_cache(maxsize=32)
def _tabulated(kappa: float) -> TabulatedCap:
    from stretch_bt.simulation.balloons.table import read_table

    return read_table().at(kappa)


@lru_cache(maxsize=8)
def _solved(radius: float, pressure: float, elements: int, limit: float) -> Law:
    from stretch_bt.simulation.balloons.cap import Cap
    from stretch_bt.simulation.balloons.online import SolvedCap

    return SolvedCap(Cap(radius, pressure, hand=HAND, elements=elements), limit)
