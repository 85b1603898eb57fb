"""A simulated operator."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stretch_bt.errors import DeviceFault, InvalidInput
from stretch_bt.hardware.driver import OperatorDriver, Options, Poll
from stretch_bt.hardware.indenters import described
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.units import Time
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.objects.base import ObjectSpec, Point

__all__ = ["SimulatedOperator", "indenter"]

_ROUNDING = 1e-9
_ROOM = 0.002  # m between an indenter and the hand that a person needs
_BASE = "40 mm"  # height of the stand


class _Options(Options):
    type: Literal["Operator"]
    use: Literal["simulated"]
    delay: Annotated[Time, Within(0.0, 3600.0, "Time")] = Field(
        default=20.0, description="time until a request is carried out"
    )
    look: Annotated[Time, Within(0.0, 3600.0, "Time")] = Field(
        default=5.0, description="time until the robot's next action is confirmed"
    )


class SimulatedOperator(OperatorDriver):
    """Puts a rigid indenter on a stand of 40 mm in the place of the scene's object; refuses while the hand is in the way."""

    Options = _Options
    simulated = any_clock = True

    def mount(self, geometry: str, size: float) -> Poll:
        """Exchange the object once the delay is over; until then the one before it stands there."""
        spec = indenter(geometry, size, self.cell.twin.scene.object.position)
        self._check_clear(spec, geometry, size)
        end = self.cell.now() + self.options.delay
        mounted = False

        def poll() -> MotionState:
            nonlocal mounted
            if self.cell.now() < end - _ROUNDING:
                return MotionState.MOVING
            if not mounted:
                self._check_clear(spec, geometry, size)
                self._exchange(spec)
                mounted = True
            return MotionState.DONE

        return poll

    def confirm(self, request: str) -> Poll:
        """Agree after as long as it takes to look."""
        end = self.cell.now() + self.options.look
        return lambda: MotionState.MOVING if self.cell.now() < end - _ROUNDING else MotionState.DONE

    def _exchange(self, spec: ObjectSpec) -> None:
        try:
            self.cell.twin.exchange(spec)
        except InvalidInput as error:
            raise DeviceFault(self.name, str(error)) from None

    def _check_clear(self, spec: ObjectSpec, geometry: str, size: float) -> None:
        """Raise DeviceFault while the hand touches, or stands where the indenter will be."""
        twin = self.cell.twin
        now = self.cell.now()
        if twin.contact(now).place is not None:
            raise DeviceFault(self.name, "the hand touches the object; retract it before mounting another one")
        least = spec.top + _ROOM
        height = twin.hand.at(now).true.height
        if height < least:
            raise DeviceFault(
                self.name,
                f"the hand is at {height * 1e3:.4g} mm, where {described(geometry, size)} comes to stand; "
                f"raise it above {least * 1e3:.4g} mm first",
            )


def indenter(geometry: str, size: float, where: Point) -> ObjectSpec:
    """Return a rigid indenter on the stand: of a diameter, m, or an angle, rad."""
    from stretch_bt.simulation.objects.cone import ConeObject
    from stretch_bt.simulation.objects.cylinder import CylinderObject
    from stretch_bt.simulation.objects.sphere import SphereObject

    common = {"type": geometry, "base": _BASE, "position": where, "rigid": True}
    made: dict[str, tuple[type[ObjectSpec], dict[str, str]]] = {
        "sphere": (SphereObject, {"diameter": f"{size!r} m"}),
        "cylinder": (CylinderObject, {"diameter": f"{size!r} m", "height": "20 mm"}),
        "cone": (ConeObject, {"angle": f"{size!r} rad", "height": "40 mm"}),
    }
    kind, sizes = made[geometry]
    return kind.model_validate({**common, **sizes})
