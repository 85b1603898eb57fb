"""A cube of material points that is rolled and pressed, and how round it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from mpm.kernel import advance
from stretch_bt.errors import NoEquilibrium

__all__ = ["Body", "Hand", "Stuff"]

Array = npt.NDArray[np.float64]

POISSON = 0.4
COURANT = 0.35
PER_CELL = 2  # points along each edge of a cell
INERTIA = 0.02  # density times speed^2 over the yield stress: how fast may be rolled
TABLE = 20.0  # its stiffness per depth, in moduli over an edge
PIECE = 200  # steps between two looks at the heights


@dataclass(frozen=True, slots=True)
class Stuff:
    """Yield stress and modulus, Pa, density, kg/m^3, and friction on table and hand."""

    yield_stress: float
    modulus: float
    density: float = 1250.0
    grip: float = 3.0

    @property
    def shear(self) -> float:
        """Shear modulus, Pa."""
        return self.modulus / (2 * (1 + POISSON))

    @property
    def bulk(self) -> float:
        """Bulk modulus, Pa."""
        return self.modulus / (3 * (1 - 2 * POISSON))

    @property
    def sound(self) -> float:
        """Speed of pressure waves, m/s."""
        return math.sqrt((self.bulk + 4 / 3 * self.shear) / self.density)

    @property
    def speed(self) -> float:
        """That of the hand, m/s, at which inertia is small beside the yield stress."""
        return math.sqrt(INERTIA * self.yield_stress / self.density)


@dataclass(frozen=True, slots=True)
class Hand:
    """A soft foundation, N/m^3, or a plate where it is infinite."""

    foundation: float = 2.6e5

    @property
    def soft(self) -> bool:
        """Whether the lump sinks into it."""
        return math.isfinite(self.foundation)


@dataclass(eq=False)
class Body:
    """A cube of an edge, m, of so many cells to the edge; changes in place."""

    edge: float
    stuff: Stuff
    cells: int = 6
    steps: int = 0
    heights: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        count = PER_CELL * self.cells
        self.pitch = self.edge / count
        line = (np.arange(count) + 0.5) * self.pitch
        x, y, z = np.meshgrid(line - self.edge / 2, line - self.edge / 2, line, indexing="ij")
        self.places = np.ascontiguousarray(np.stack([x, y, z], axis=-1).reshape(-1, 3))
        n = len(self.places)
        self.speeds = np.zeros((n, 3))
        self.affine = np.zeros((n, 3, 3))
        self.strains = np.tile([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], (n, 1))
        self.contents, self.slid = np.ones(n), np.zeros(n)
        self.crept = np.zeros((n, 2, 2))
        self.dx = self.edge / self.cells
        self.dt = COURANT * self.dx / self.stuff.sound
        self.hand = np.array([self.edge, 0.0])
        self.grid = np.zeros((*(3 * [math.ceil(2.6 * self.cells) + 6]), 4))

    @property
    def ball(self) -> float:
        """Radius of the ball of its volume, m."""
        return self.edge * math.cbrt(0.75 / math.pi)

    @property
    def height(self) -> float:
        """From its lowest to its highest point, m."""
        return float(np.ptp(self.places[:, 2])) + self.pitch

    def roll(self, ways: Array, forces: Array, hand: Hand) -> None:
        """Roll it along legs (m, 2), m of the hand, under forces (m,), N."""
        lengths = np.linalg.norm(ways, axis=1)
        counts = np.maximum(np.round(lengths / (self.stuff.speed * self.dt)), 1).astype(int)
        speeds = np.repeat(ways / (counts * self.dt)[:, None], counts, axis=0)
        self._go(speeds, np.repeat(forces, counts), hand)

    def settle(self, force: float, hand: Hand, seconds: float = 0.02) -> None:
        """Let the hand come to a force, N, while it stands."""
        steps = math.ceil(seconds / self.dt)
        self._go(np.zeros((steps, 2)), np.full(steps, force), hand)

    def press(self, height: float, friction: float) -> float:
        """Press it between rigid plates to a height, m, with a friction of theirs, and return the force, N."""
        speed = 0.5 * self.stuff.speed
        self.hand[0] = float(self.places[:, 2].max()) + self.pitch / 2
        steps = math.ceil((self.hand[0] - height) / (speed * self.dt))
        self._go(np.zeros((steps, 2)), np.zeros(steps), Hand(math.inf), fall=speed, grip=friction)
        return float(self.hand[1])

    def _go(self, speeds: Array, forces: Array, hand: Hand, fall: float = 0.0, grip: float | None = None) -> None:
        stiffness = TABLE * self.stuff.modulus / self.edge  # N/m^3
        numbers = np.array(
            [
                self.dx,
                self.dt,
                self.pitch**3,
                self.stuff.density,
                self.stuff.bulk,
                self.stuff.shear,
                self.stuff.yield_stress,
                stiffness * self.pitch**2,
                hand.foundation if hand.soft else stiffness * self.pitch**2,
                self.pitch / 2,
                self.stuff.grip if grip is None else grip,
                9.81,
            ]
        )
        for first in range(0, len(speeds), PIECE):
            part = slice(first, first + PIECE)
            own = self.places, self.speeds, self.affine, self.strains, self.contents, self.slid, self.crept, self.grid
            inside = advance(
                *own, np.ascontiguousarray(speeds[part]), forces[part].copy(), fall, self.hand, hand.soft, numbers
            )
            self.steps += len(speeds[part])
            if not (inside and np.isfinite(self.places).all()):
                raise NoEquilibrium(f"the points left the grid after {self.steps} steps")
            self.heights.append(self.height)
