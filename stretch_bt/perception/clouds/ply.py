"""Clouds as PLY files, which every viewer of point clouds reads."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.clouds.cloud import Array, Cloud

__all__ = ["colours", "encode", "points_of"]

_FIELDS = (
    ("x", "double", "<f8"),
    ("y", "double", "<f8"),
    ("z", "double", "<f8"),
    ("red", "uchar", "u1"),
    ("green", "uchar", "u1"),
    ("blue", "uchar", "u1"),
    ("sd", "float", "<f4"),
    ("seen", "int", "<i4"),
)
_STOPS = np.array([[33, 81, 160], [70, 170, 160], [240, 200, 70], [200, 50, 60]], float)


def colours(sd: Array) -> npt.NDArray[np.uint8]:
    """Return red, green and blue (n, 3) of standard deviations: blue for the least, over yellow to red for the most."""
    low, high = (float(sd.min()), float(sd.max())) if len(sd) else (0.0, 1.0)
    share = (sd - low) / (high - low) if high > low else np.zeros_like(sd)
    places = np.linspace(0.0, 1.0, len(_STOPS))
    return np.column_stack([np.interp(share, places, stop) for stop in _STOPS.T]).round().astype(np.uint8)


def encode(cloud: Cloud, *, text: bool = False) -> bytes:
    """Return the bytes of a PLY file: points and standard deviations in m, colours by standard deviation."""
    rows = np.zeros(len(cloud), dtype=[(name, kind) for name, _, kind in _FIELDS])
    rows["x"], rows["y"], rows["z"] = cloud.points.T
    rows["red"], rows["green"], rows["blue"] = colours(cloud.sd).T
    rows["sd"], rows["seen"] = cloud.sd, cloud.seen
    header = [
        "ply",
        f"format {'ascii' if text else 'binary_little_endian'} 1.0",
        f"comment lengths in metres, frame of the {cloud.frame}; sd is the standard deviation along the view",
        f"element vertex {len(cloud)}",
        *(f"property {kind} {name}" for name, kind, _ in _FIELDS),
        "end_header",
    ]
    file = io.BytesIO()
    file.write(("\n".join(header) + "\n").encode("ascii"))
    if text:
        np.savetxt(file, rows, fmt="%.9g %.9g %.9g %d %d %d %.5g %d")
    else:
        file.write(rows.tobytes())
    return file.getvalue()


def points_of(data: bytes) -> Array:
    """Return the points (n, 3), m, of a binary file that `encode` made.

    Raises
    ------
    InvalidInput
        It is another file.
    """
    head, end, body = data.partition(b"end_header\n")
    kind = np.dtype([(name, kind) for name, _, kind in _FIELDS])
    if not (end and head.startswith(b"ply\nformat binary_little_endian") and len(body) % kind.itemsize == 0):
        raise InvalidInput("this is no binary PLY file of a cloud; write one with save()")
    rows = np.frombuffer(body, dtype=kind)
    return np.column_stack([rows["x"], rows["y"], rows["z"]])
