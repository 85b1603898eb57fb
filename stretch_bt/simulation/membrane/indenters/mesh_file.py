"""Bodies in mesh files, such as STL, OBJ and PLY, through trimesh."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from stretch_bt.errors import InvalidInput, MissingExtra
from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron
from stretch_bt.source.bounds import MAX_FORM, hold

__all__ = ["load_mesh"]


def load_mesh(path: Path, unit: float, edge: float) -> Polyhedron:
    """Return the body in a file, z up, its edges rounded; its highest corner at z = 0 and its middle at (0, 0).

    Its y runs against the file's, as the y of all bodies against the world's.

    Parameters
    ----------
    path
        A file that trimesh reads.
    unit
        Length of one unit of the file, m: most files do not say.
    edge
        Radius of the rounding, m.

    Raises
    ------
    MissingExtra
        trimesh is not installed.
    InvalidInput
        The file cannot be read, is larger than `MAX_FORM`, holds no closed surface, or is thinner somewhere than two roundings.
    """
    if not path.is_file():
        raise InvalidInput(f"there is no file {path}; write its path as seen from the scene")
    hold(str(path), path.stat().st_size, MAX_FORM, "save it with fewer triangles")
    return _loaded(path, path.stat().st_mtime_ns, unit, edge)


@lru_cache(maxsize=8)
def _loaded(path: Path, changed: int, unit: float, edge: float) -> Polyhedron:
    """Return the body in a file as it was when it last changed."""
    vertices, triangles = _read(path)
    if len(triangles) == 0:
        raise InvalidInput(f"{path} holds no triangles")
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]])
    try:
        mirrored = (vertices - middle) * unit * np.array([1.0, -1.0, 1.0])
        return Polyhedron(mirrored, triangles[:, ::-1], edge, endless=False)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None


def _read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) in units of the file, equal ones merged, and triangles (m, 3) that face outwards."""
    try:
        import trimesh
    except ImportError:
        raise MissingExtra("mesh files need trimesh: pip install 'stretch-bt[mesh]'") from None
    try:
        mesh = trimesh.load_mesh(path)
    except Exception as error:  # each format fails in its own way
        raise InvalidInput(f"{path} cannot be read as a mesh: {error}") from None
    if not isinstance(mesh, trimesh.Trimesh):
        raise InvalidInput(f"{path} holds no surface of triangles")
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    if mesh.is_winding_consistent and mesh.is_watertight and mesh.volume < 0:
        mesh.invert()
    return np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64)
