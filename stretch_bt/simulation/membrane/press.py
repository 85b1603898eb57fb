"""One press of the membrane by any of its solvers: `hertz`, `axisymmetric` or `sheet`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stretch_bt.errors import InvalidInput
from stretch_bt.plain_numbers import is_number
from stretch_bt.simulation.membrane.axisymmetric import AxisymmetricPress, CircularMembrane
from stretch_bt.simulation.membrane.indenters.base import Indenter, Solid
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.parse import parse_indenter
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import Material, NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.settings import Settings

if TYPE_CHECKING:  # numba comes along with it
    from stretch_bt.simulation.membrane.sheet.result import SheetPress

__all__ = ["SOLVERS", "ContactPatch", "PressResult", "press"]

SHEAR_MODULUS = 47.4e3  # Pa, the neo-Hookean value of EcoFlex 00-50 from its 100 % modulus of 83 kPa
WIDTH, THICKNESS, GAUGE = 0.090, 0.002, 0.100
MOST_STRETCH, MOST_DEPTH = 8.0, 2.0  # gauges; the softest silicones tear at some 10 times their length
_ROUND = (
    "the axisymmetric solver stands a round membrane in for the rectangular one: no error of the force is stated, as the "
    "model's is not known; the sheet solver states one"
)
_CALIBRATED = (
    "the hertz solver gives the law that was calibrated on another hand, not the force of this membrane: no error of the "
    "force is stated, as the model's is not known; the sheet solver states one"
)


@dataclass(frozen=True, slots=True)
class ContactPatch:
    """Where the indenter touches: deformed area, m^2, and quadrature points in contact.

    `radius`, m, is the radius of the disc with the area seen along z; None where the indenter is not a body of revolution.
    """

    area: float
    radius: float | None
    nodes: int


@dataclass(frozen=True, slots=True)
class PressResult:
    """A press: force and its estimated error, N, along z; `seconds` is CPU time of the solve.

    `force_error` is None where the solver is a model of the membrane whose own error is not known; a warning says so.
    `detail` is the solver's own result: a SheetPress can start another press.
    """

    force: float
    force_error: float | None
    contact: ContactPatch
    balance: float
    iterations: int
    residual: float
    seconds: float
    warnings: tuple[str, ...] = ()
    detail: SheetPress | AxisymmetricPress | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `press --json` prints."""
        radius = self.contact.radius
        return {
            "force_N": self.force,
            "force_error_N": self.force_error,
            "contact": {
                "area_mm2": self.contact.area * 1e6,
                "radius_mm": None if radius is None else radius * 1e3,
                "nodes": self.contact.nodes,
            },
            "balance": self.balance,
            "iterations": self.iterations,
            "residual": self.residual,
            "seconds": self.seconds,
        }


@dataclass(frozen=True, slots=True)
class _Request:
    indenter: Indenter | Several
    stretch: float
    depth: float
    at: tuple[float, float]
    tilt: tuple[float, float]
    sheet: Sheet
    settings: Settings
    start: SheetPress | None


def press(
    indenter: str | Indenter | Several,
    stretch: float,
    depth: float,
    *,
    solver: str = "sheet",
    mesh: float | None = None,
    shear_modulus: float = SHEAR_MODULUS,
    mount_prestretch: float = 0.0,
    gauge: float = GAUGE,
    at: tuple[float, float] = (0.0, 0.0),
    tilt: tuple[float, float] = (0.0, 0.0),
    effects: Iterable[str] | Effects = (),
    width: float = WIDTH,
    thickness: float = THICKNESS,
    material: Material | None = None,
    settings: Settings | None = None,
    start: PressResult | SheetPress | None = None,
) -> PressResult:
    """Return the force with which an indenter presses on the stretched membrane, and the contact.

    The membrane is `width` x `gauge` x `thickness`, its ends clamped with their width held, its sides free; the depth
    counts from the flat stretched plane to the highest point of the indenter. No friction, weight or other effect acts
    unless it is named.

    Parameters
    ----------
    indenter
        A shape, or text such as `sphere:20mm`.
    stretch, depth
        How far the clamps are pulled past the gauge, and how far the indenter is pressed, m.
    solver
        `sheet`, the finite-strain membrane; `axisymmetric`, a round membrane of the same area and mean stretch; or
        `hertz`, the calibrated law of the hand.
    mesh
        Length of the smallest elements of the sheet, m; by default it suits the indenter.
    shear_modulus, material
        Shear modulus of a neo-Hookean membrane, Pa, or any other material.
    mount_prestretch
        Distance between the clamps at stretch 0 less the length of the unstressed membrane, m.
    at, tilt
        Where the indenter's axis is, (x, y), m, and its turns about x and then y, rad.
    effects
        Names of effects, or Effects with their parameters.
    start
        An earlier press of the same membrane by the sheet solver to start from; it stays as it is.

    Raises
    ------
    InvalidInput
        An argument is out of range, or the solver does not take it.
    NoEquilibrium
        There is no equilibrium, or none was found within the budget; `.reason` says which.
    """
    if not isinstance(solver, str) or solver not in SOLVERS:
        raise InvalidInput(f"the solver must be one of {', '.join(SOLVERS)}, not {solver!r}")
    _finite("stretch", stretch, 0.0, "m")
    _finite("depth", depth, 0.0, "m")
    if depth == 0:
        raise InvalidInput("the depth must be above 0 m: at 0 nothing presses")
    body = parse_indenter(indenter) if isinstance(indenter, str) else indenter
    if not isinstance(body, Solid | Several) and not isinstance(body, Indenter):
        raise InvalidInput(f"an indenter is a shape or text such as 'sphere:20mm', not {indenter!r}")
    if not (material is None or isinstance(material, Material)):
        raise InvalidInput(f"a material is one of stretch_bt.simulation, such as NeoHookean(47.4e3), not {material!r}")
    if not (settings is None or isinstance(settings, Settings)):
        raise InvalidInput(f"settings are Settings(...), not {settings!r}")
    chosen = effects if isinstance(effects, Effects) else Effects.named(effects)
    sheet = Sheet(gauge, width, thickness, material or NeoHookean(shear_modulus), mount_prestretch, chosen)
    _check_unit("stretch", stretch, MOST_STRETCH, gauge)
    _check_unit("mount_prestretch", mount_prestretch, MOST_STRETCH, gauge)
    _check_unit("depth", depth, MOST_DEPTH, gauge)
    if settings is None:
        settings = Settings(mesh=mesh)
    elif mesh is not None:
        raise InvalidInput("give the mesh on its own or within the settings, not both")
    return SOLVERS[solver](_Request(body, stretch, depth, _pair(at), _pair(tilt), sheet, settings, _earlier(start)))


def _earlier(start: PressResult | SheetPress | None) -> SheetPress | None:
    """Return the sheet that a press may start from."""
    if start is None:
        return None
    from stretch_bt.simulation.membrane.sheet.result import SheetPress

    earlier = start.detail if isinstance(start, PressResult) else start
    if not isinstance(earlier, SheetPress):
        raise InvalidInput("only a press by the sheet solver can start another one")
    return earlier


def _sheet(request: _Request) -> PressResult:
    from stretch_bt.simulation.membrane.sheet.result import Load
    from stretch_bt.simulation.membrane.sheet.solver import solve

    load = Load(request.indenter, request.stretch, request.depth, request.at, request.tilt, _hang(request))
    solved = solve(request.sheet, load, request.settings, request.start)
    region = solved.region()
    turned = isinstance(request.indenter, Sphere | Cylinder | Cone)
    return PressResult(
        float(solved.force[2]),
        solved.force_error,
        ContactPatch(region.area, region.radius if turned else None, solved.nodes),
        solved.balance,
        solved.iterations,
        solved.residual,
        solved.seconds,
        solved.warnings,
        solved,
    )


def _hang(request: _Request) -> float:
    """Return how far the sheet hangs over the indenter before it is touched, m."""
    if request.sheet.effects.sag <= 0:
        return 0.0
    from stretch_bt.simulation.membrane.sheet.hanging import hang, lift, profile

    hangs = profile(hang(request.sheet, request.stretch))
    return lift(hangs, request.sheet, request.stretch, request.indenter, request.at)


def _axisymmetric(request: _Request) -> PressResult:
    sheet, body = request.sheet, request.indenter
    _plain("axisymmetric", request)
    if not isinstance(body, Sphere):
        raise InvalidInput("the axisymmetric solver takes a sphere only")
    length = sheet.gauge + sheet.mount_prestretch + request.stretch
    round_sheet = CircularMembrane.in_place_of(sheet.width, sheet.gauge, length, sheet.thickness, sheet.material)
    solved = round_sheet.press(body.diameter / 2, request.depth)
    radius = solved.contact_radius
    area = 2 * math.pi * (body.diameter / 2) ** 2 * (1 - math.cos(solved.contact_angle))
    return PressResult(
        solved.force,
        None,
        ContactPatch(area, radius, 0),
        solved.residual,
        solved.iterations,
        solved.residual,
        solved.seconds,
        (_ROUND,),
        solved,
    )


def _hertz(request: _Request) -> PressResult:
    from stretch_bt.model.force.calibrated import CalibratedHertz
    from stretch_bt.model.force.force_model import ForceModel
    from stretch_bt.model.hertz import hertz_force

    body, sheet = request.indenter, request.sheet
    _plain("hertz", request)
    if (sheet.gauge, sheet.width, sheet.mount_prestretch) != (GAUGE, WIDTH, 0.0):
        raise InvalidInput(
            "the hertz solver knows the membrane of the hand only; the sheet solver takes any size and mount"
        )
    if not isinstance(body, Sphere | Cylinder):
        raise InvalidInput("the hertz solver takes a sphere or a cylinder")
    model = ForceModel.default()
    assert isinstance(model, CalibratedHertz)
    model.range.check(depth=request.depth)
    began = time.process_time()
    radius, shape = body.diameter / 2, "sphere" if isinstance(body, Sphere) else "cylinder"
    modulus, _ = model.modulus(radius, request.stretch)
    # the calibration is of the hand's membrane; a force is proportional to shear modulus x thickness
    scale = sheet.material.shear_modulus * sheet.thickness / (SHEAR_MODULUS * THICKNESS)
    force = scale * float(hertz_force(shape, request.depth, modulus, radius=radius))
    touching = math.sqrt(radius * request.depth) if shape == "sphere" else radius
    return PressResult(
        force,
        None,
        ContactPatch(math.pi * touching**2, touching, 0),
        0.0,
        0,
        0.0,
        time.process_time() - began,
        (_CALIBRATED,),
    )


def _plain(solver: str, request: _Request) -> None:
    """Raise InvalidInput for arguments that only the sheet solver takes."""
    extras = {
        "at": request.at != (0.0, 0.0),
        "tilt": request.tilt != (0.0, 0.0),
        "effects": request.sheet.effects != Effects(),
        "mesh": request.settings != Settings(),
        "start": request.start is not None,
    }
    given = [name for name, is_given in extras.items() if is_given]
    if given:
        raise InvalidInput(f"the {solver} solver takes no {given[0]}; the sheet solver does")


def _finite(name: str, value: float, least: float, unit: str) -> None:
    if not (is_number(value) and value >= least):
        raise InvalidInput(f"{name} must be a finite number of at least {least:g} {unit}, not {value!r}")


def _check_unit(name: str, value: float, most: float, gauge: float) -> None:
    """Raise InvalidInput for a length that no membrane of such a gauge reaches, as millimetres given for metres."""
    if value > most * gauge:
        raise InvalidInput(
            f"{name} {value:g} m is more than {most:g} times the gauge, {gauge:g} m, which no membrane of this kind reaches; lengths are in"
            " m, as in 0.03 for 30 mm"
        )


def _pair(values: Iterable[float]) -> tuple[float, float]:
    try:
        pair = tuple(float(v) for v in values)
    except (TypeError, ValueError):
        pair = ()
    if len(pair) != 2:
        raise InvalidInput(f"a place and a tilt have two numbers each, not {values!r}")
    return pair[0], pair[1]


SOLVERS: dict[str, Callable[[_Request], PressResult]] = {
    "hertz": _hertz,
    "axisymmetric": _axisymmetric,
    "sheet": _sheet,
}
