"""Hands that no force model knows, and the forces that a characterisation measures on them.

Each seed draws shear modulus, thickness and mount pre-stretch within 20 % of the twin's, Mooney and Rivlin's energy with a share of 5 to
24 % in half of the hands, friction of 0.2 to 0.6, and softening of 5 to 15 %; the sheet has its weight and its bending and a finer
mesh than the model's table.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium
from stretch_bt.model.calibration.measurements import Measurements
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import rubber
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects, Mullins
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.hanging import lowest
from stretch_bt.simulation.membrane.sheet.result import Load, SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

__all__ = [
    "DEPTHS",
    "DIAMETERS",
    "FINER",
    "STRETCHES",
    "TrueHand",
    "forces_of",
    "measured",
    "measured_at",
]

Array = npt.NDArray[np.float64]

DIAMETERS = np.array([10, 20, 30, 45, 60]) * 1e-3
STRETCHES = np.array([0, 10, 20, 30, 40, 50, 60, 80]) * 1e-3
DEPTHS = np.linspace(1e-3, 15e-3, 15)
TRIALS = 5
SENSOR, ROBOT, MOUNTED = 0.02, 5e-5, 5e-5  # N, m, m: of a reading, of where the arm stops, of the height of an indenter
SEEN = 1.3e-4  # m: of all heights of first contact, as `characterize` finds them with the bench camera
FINER = Settings(coarsen=0.5)
_MESHES = (1.0, 0.9, 1.1, 1.2)


@dataclass(frozen=True)
class TrueHand:
    """A hand that a seed draws."""

    shear_modulus: float
    thickness: float
    mount_prestretch: float
    share: float
    friction: float
    softening: float

    @classmethod
    def drawn(cls, seed: int) -> TrueHand:
        """Return the hand of a seed."""
        random = np.random.default_rng([seed, 61])
        modulus, thickness, mount = np.array([SHEAR_MODULUS, 0.002, MOUNT_PRESTRETCH]) * random.uniform(0.8, 1.2, 3)
        share, friction, softening = random.uniform([0.05, 0.2, 0.05], [0.24, 0.6, 0.15])
        return cls(*map(float, (modulus, thickness, mount, share if seed % 2 else 0.0, friction, softening)))

    def sheet(self) -> Sheet:
        """Return its membrane."""
        effects = Effects(sag=DENSITY, bending=True, friction=self.friction, mullins=Mullins(r=1 / self.softening))
        return Sheet(0.1, 0.09, self.thickness, rubber(self.shear_modulus, self.share), self.mount_prestretch, effects)


def forces_of(sheet: Sheet, diameters: Array, stretches: Array, depths: Array, settings: Settings) -> Array:
    """Return (diameters, stretches, depths) float, N; a membrane that softens is pressed deep at the largest stretch first."""
    hangs = {float(x): lowest(sheet, float(x)) for x in stretches}
    press = partial(_pressed, sheet, settings, hangs)
    found, past = np.zeros((len(diameters), len(stretches), len(depths))), None
    for i, diameter in enumerate(diameters):
        ball = Sphere(float(diameter))
        if sheet.effects.mullins:
            past = press(ball, float(stretches[-1]), float(depths[-1]), past).let_go()
        for j, stretch in enumerate(stretches):
            here: SheetPress | None = past
            for k, depth in enumerate(depths):
                here = press(ball, float(stretch), float(depth), here)
                found[i, j, k] = here.force[2]
            past = here.let_go() if here is not None and sheet.effects.mullins else None
    return found


def _pressed(
    sheet: Sheet,
    settings: Settings,
    hangs: dict[float, float],
    ball: Sphere,
    stretch: float,
    depth: float,
    past: SheetPress | None,
) -> SheetPress:
    """Return a press; where its energy is lost in rounding, as on some meshes at first contact, it is solved on another mesh."""
    load = Load(ball, stretch, depth, (0.0, 0.0), (0.0, 0.0), hangs[stretch])
    for scale in _MESHES[:-1]:
        with suppress(NoEquilibrium):
            return solve(sheet, load, replace(settings, coarsen=scale * settings.coarsen), past)
    return solve(sheet, load, replace(settings, coarsen=_MESHES[-1] * settings.coarsen), past)


def measured(true: Array, seed: int) -> Measurements:
    """Return the measurements of forces (diameters, stretches, depths) in five trials of the protocol with noise."""
    return measured_at(true, DIAMETERS, STRETCHES, DEPTHS, seed)


def measured_at(true: Array, diameters: Array, stretches: Array, depths: Array, seed: int) -> Measurements:
    """Return the mean force of each state over five trials, and its standard deviation by the sensor's noise."""
    random = np.random.default_rng([seed, 62])
    slopes = np.gradient(np.log(true), np.log(depths), axis=-1) * true / depths
    moved = random.normal(0, ROBOT, (TRIALS, *true.shape)) + random.normal(0, MOUNTED, (len(diameters), 1, 1))
    moved += random.normal(0, SEEN)
    force = (true + slopes * moved + random.normal(0, SENSOR, moved.shape)).mean(axis=0)
    d, x, z = (a.ravel() for a in np.meshgrid(diameters, stretches, depths, indexing="ij"))
    return Measurements(d / 2, x, z, force.ravel(), np.full(len(d), SENSOR / np.sqrt(TRIALS)))
