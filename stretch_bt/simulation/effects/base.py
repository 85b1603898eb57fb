"""An effect: one physical or sensor phenomenon that a scene can switch on.

A new effect is one file in this folder with one subclass of the base of its group. It is constructed only when it is on; the
class itself answers whether a scene can have it and how much it would change, in closed form.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict

from stretch_bt.errors import InvalidInput

if TYPE_CHECKING:
    from stretch_bt.frames import Intrinsics
    from stretch_bt.simulation.advisor.case import Case
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects
    from stretch_bt.simulation.objects.base import ObjectSpec
    from stretch_bt.simulation.objects.response import Response
    from stretch_bt.simulation.scene.file import Scene

__all__ = [
    "CameraEffect",
    "Effect",
    "Exposure",
    "Group",
    "MembraneEffect",
    "ObjectEffect",
    "Observable",
    "Parameters",
    "RobotEffect",
    "Size",
]

Group = Literal["membrane", "object", "camera", "robot"]
Observable = Literal["height", "size", "force", "stiffness", "roundness"]
Image = npt.NDArray[np.float32]


class Parameters(BaseModel):
    """Numbers of an effect, SI; numbers in a file carry their units."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Size(NamedTuple):
    """The change of an observable by an effect, in the unit of that observable's tolerance, and the numbers behind it.

    `height` and `size` are in m, `force` and `stiffness` are parts of their value, `roundness` is a standard deviation of
    radius over the mean radius. `way` is 1 where it makes the observable larger, -1 where smaller, 0 where that is not known. `value` is
    infinite where no estimate holds, so that the effect is on in any case.
    """

    observable: Observable
    value: float
    why: str
    way: int = 0


class Effect(ABC):
    """One phenomenon, switched on; `parameters` are its numbers in the scene."""

    name: ClassVar[str]
    group: ClassVar[Group]
    #: where in its group it is applied: from the world to the reading
    order: ClassVar[int] = 0
    #: CPU time of one core that it adds, ms, and to what: "frame", "solve", "step" or "reading"
    cost_ms: ClassVar[float]
    cost_per: ClassVar[str]
    Parameters: ClassVar[type[Parameters]] = Parameters
    #: share of a tolerance from which it is called for
    worth: ClassVar[float] = 1.0
    #: observables of which its estimate holds under one object only, and none where several hold the membrane
    under_one: ClassVar[tuple[Observable, ...]] = ()
    #: the effect without which it changes nothing
    needs: ClassVar[str | None] = None

    def __init__(self, parameters: Any) -> None:
        self.parameters = parameters

    @classmethod
    def refusal(cls, spec: ObjectSpec) -> str | None:
        """Return why an object cannot have it, None when it can."""
        return None

    @classmethod
    def not_at(cls, scene: Scene) -> str | None:
        """Return why it does not exist at a scene's fidelity or with its camera, None when it does."""
        return None

    @classmethod
    @abstractmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield its change of each observable, in closed form."""


class MembraneEffect(Effect):
    """Changes the sheet."""

    group = "membrane"

    @classmethod
    def not_at(cls, scene: Scene) -> str | None:
        """Only the sheet has it."""
        return None if scene.is_sheet else f"{scene.fidelity} fidelity has none of the membrane's effects"

    @abstractmethod
    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with this one added."""


class ObjectEffect(Effect):
    """Changes how the object answers; an object names the effects that it can have in its `effects`."""

    group = "object"

    @classmethod
    def refusal(cls, spec: ObjectSpec) -> str | None:
        """Refuse an object that does not name it."""
        if cls.name in spec.effects:
            return None
        return f"{spec.noun} cannot have {cls.name.replace('_', ' ')}"

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return how the object answers with this effect, given how it answers without; None is rigid."""
        raise InvalidInput(f"{self.name} does not act on the force of {spec.noun}")


class Exposure:
    """One frame on its way from the surface to the counts.

    `depth` is (h, w) float32, m, along the optical axis, 0 where there is no value; effects change it in place or put
    another in its place. `unit` is one count, m. `random(name)` is the noise source of an effect for this frame, and
    `random(name, k)` the one for frame k, -1 for noise that is the same in all frames of a run: the same for the same
    seed, whatever was asked before.
    """

    def __init__(
        self,
        depth: Image,
        intrinsics: Intrinsics,
        time: float,
        number: int,
        rate: float,
        random: Callable[[str, int], np.random.Generator],
        unit: float,
    ) -> None:
        self.depth = depth
        self.intrinsics = intrinsics
        self.time = time
        self.number = number
        self.rate = rate
        self.unit = unit
        self._random = random

    def random(self, name: str, number: int | None = None) -> np.random.Generator:
        """Return the noise source of an effect for a frame, this one unless its number is given."""
        return self._random(name, self.number if number is None else number)


class CameraEffect(Effect):
    """Changes the camera's frames."""

    group = "camera"

    @classmethod
    def not_at(cls, scene: Scene) -> str | None:
        """Return None where the scene names it or its camera adds it."""
        if scene.choice(cls.name) != "auto" or scene.camera_adds(cls.name):
            return None
        return f"the camera {scene.camera!r} does not add it"

    def expose(self, exposure: Exposure) -> None:
        """Change the depth of a frame."""

    def lens(self, intrinsics: Intrinsics) -> Intrinsics:
        """Return the intrinsics of the lens that the scene is seen through, given the camera's reported ones."""
        return intrinsics


class RobotEffect(Effect):
    """Changes where the hand is, when it is read, or the force that is read; each hook does nothing unless it is its own."""

    group = "robot"
    #: kind of device whose force it makes noisy, the only one for which `force_sd` is more than 0
    noisy: ClassVar[str | None] = None

    def height_error(self, random: np.random.Generator) -> float:
        """Return the error of the height at the end of a move, m."""
        return 0.0

    def delay(self, device: str) -> float:
        """Return the age of the readings of a kind of device (`Arm`, `DepthCamera`, `ForceSensor`), s."""
        return 0.0

    def force_sd(self, device: str) -> float:
        """Return the standard deviation, N an axis, of the noise of the force that a kind of device reads."""
        return 0.0

    def force_error(self, device: str, random: np.random.Generator) -> npt.NDArray[np.float64]:
        """Return (3,) float, N, the error added to the force that a kind of device reads."""
        sd = self.force_sd(device)
        return random.normal(0.0, sd, 3) if sd > 0 else np.zeros(3)
