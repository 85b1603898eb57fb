"""A cloud of surface points, each with its standard deviation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_path
from stretch_bt.brief import BriefRepr
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.frames import as_numbers, as_reals
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Length

__all__ = ["CELL", "FLOOR", "Array", "Cloud", "Frame", "cloud_of"]

Array = npt.NDArray[np.float64]
Frame = Literal["world", "hand"]

CELL = 0.5e-3  # m
FARTHEST = 2.0**62  # cells, whose numbers are int64
FLOOR = 0.1e-3  # m; an arm of this class returns to a pose within it


@dataclass(frozen=True, slots=True, repr=False)
class Cloud(BriefRepr):
    """Points of an object's surface, fused from any number of contacts.

    Parameters
    ----------
    points : (n, 3) float, m, in `frame`
        The surface, each point the mean of those in one column.
    noise : (n,) float, m
        Standard deviation of each point along its ray, by the noise of the frames alone.
    rays : (n, 3) float, unit vectors, in `frame`
        Directions from the camera through the points.
    seen : (n,) int64
        In how many contacts each was found.
    columns : (n, 3) int64
        Axis along which a point was averaged, 0 to 2 for x to z, and its cell across that axis, `cell` m wide.
    frame : "world" or "hand"
        "hand" where no contact knew the pose of the hand: the hand's frame, with z from its height where that is known.
    cell : float, m
        Width of a column.
    floor : float, m
        Standard deviation that all points share, as of the arm's pose, and that no repetition reduces.
    contacts : int
        How many were fused.
    scatter, repeats : float and int
        Sum of squared disagreements between contacts in units of their noise, and in how many cases.
    apart : (n,) float, m, or None
        Standard deviation of each point's other errors: the membrane stands off the surface, the camera has a static error.
        No repetition reduces it. None where no map of the presses gave it.
    """

    points: Array
    noise: Array
    rays: Array
    seen: npt.NDArray[np.int64]
    columns: npt.NDArray[np.int64]
    frame: Frame = "world"
    cell: Length = CELL
    floor: Length = FLOOR
    contacts: int = 0
    scatter: float = 0.0
    repeats: int = 0
    apart: Array | None = None

    def __len__(self) -> int:
        return len(self.points)

    @property
    def disagreement(self) -> float:
        """Root mean square difference of contacts, in units of its standard deviation by their noise; 1 when noise explains it."""
        return float(np.sqrt(self.scatter / self.repeats)) if self.repeats else 1.0

    @property
    def scatter_sd(self) -> Array:
        """Standard deviation (n,) of each point along its ray against the others, m: noise, widened where contacts disagree, and the floor."""
        return np.hypot(self.noise * max(self.disagreement, 1.0), self.floor)

    @property
    def sd(self) -> Array:
        """Standard deviation (n,) of each point along its ray, m: `scatter_sd` and the other errors, `apart`, together."""
        return self.scatter_sd if self.apart is None else np.hypot(self.scatter_sd, self.apart)

    def part(self, kept: npt.NDArray[np.bool_]) -> Cloud:
        """Return the cloud of the points (n,) that are kept."""
        arrays = {name: getattr(self, name)[kept] for name in ("points", "noise", "rays", "seen", "columns")}
        return replace(self, **arrays, apart=None if self.apart is None else self.apart[kept])

    def save(self, path: str | Path, *, text: bool = False) -> None:
        """Write the cloud: as PLY, binary or text, where the path ends in .ply, as a picture where it ends in .png.

        Raises
        ------
        InvalidInput
            The path is none, has another ending, is taken, or cannot be written.
        """
        from stretch_bt.perception.clouds import picture as cloud_picture
        from stretch_bt.perception.clouds import ply

        check_path(path)
        target = Path(path)
        if target.suffix == ".ply":
            data = ply.encode(self, text=text)
        elif target.suffix == ".png":
            data = cloud_picture.encode(self)
        else:
            raise InvalidInput(f"{target.name!r} says no format; write a name such as cloud.ply or cloud.png")
        try:
            with target.open("xb") as file:
                file.write(data)
        except FileExistsError:
            raise InvalidInput(f"{target} exists; choose another name or remove it") from None
        except OSError as error:
            raise InvalidInput(f"the cloud cannot be written to {target}: {error.strerror}") from error


def cloud_of(
    points: npt.NDArray[Any],
    noise: npt.NDArray[Any] | float,
    *,
    rays: npt.NDArray[Any] | None = None,
    frame: Frame = "world",
    floor: float = FLOOR,
) -> Cloud:
    """Return points from elsewhere as a cloud; those that are not finite are left out.

    Parameters
    ----------
    points : (n, 3) float, m
    noise : (n,) float or float, m
        Positive standard deviation along the rays.
    rays : (n, 3) unit vectors
        Directions from the camera through the points; straight down unless given.

    Raises
    ------
    InvalidInput
        An array has another shape or type, or a standard deviation is not positive.
    """
    if not isinstance(frame, str) or frame not in get_args(Frame):
        raise InvalidInput(f"frame is 'world' or 'hand', got {shown(frame)[:80]}")
    if not (is_number(floor) and floor >= 0):
        raise InvalidInput(f"floor is a standard deviation in m, 0 or more, got {shown(floor)[:80]}")
    at = as_numbers("the points of a cloud are", points)
    if at.ndim != 2 or at.shape[1] != 3 or at.dtype.kind != "f":
        raise InvalidInput(f"the points of a cloud are floats of shape (n, 3), got {at.dtype} {at.shape}")
    known: Array = at.astype(np.float64)
    seen_from = np.tile([0.0, 0.0, -1.0], (len(known), 1)) if rays is None else as_reals("the rays are", rays)
    if seen_from.shape != known.shape:
        raise InvalidInput(f"the rays of {len(known)} points have shape {known.shape}, got {seen_from.shape}")
    deviations = as_reals("the noise is", noise)
    try:
        sd = np.broadcast_to(deviations, len(known))
    except ValueError:
        raise InvalidInput(
            f"the noise of {len(known)} points is one number or as many, got {np.shape(noise)}"
        ) from None
    kept = np.isfinite(known).all(axis=1) & np.isfinite(seen_from).all(axis=1)
    if not (np.isfinite(sd[kept]).all() and (sd[kept] > 0).all()):
        raise InvalidInput("the noise of a cloud is a positive standard deviation in metres")
    count = int(kept.sum())
    cells = np.floor(np.clip(known[kept, :2] / CELL, -FARTHEST, FARTHEST)).astype(np.int64)
    columns = np.column_stack([np.full(count, 2), cells])
    seen = np.ones(count, dtype=np.int64)
    return Cloud(known[kept], sd[kept].copy(), seen_from[kept], seen, columns, frame, floor=floor, contacts=1)
