"""The params that a scene file asks for, read without what makes a scene of it."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from stretch_bt.errors import FileError
from stretch_bt.source.read import load, resolve
from stretch_bt.source.values import Map, Scalar

__all__ = ["SCENES", "asked_params", "scene_params"]

#: folder of the shipped scenes
SCENES = Path(str(files("stretch_bt") / "trees" / "scenes"))


def scene_params(scene: str | Path) -> dict[Scalar, Scalar]:
    """Return the `params` of a scene file at their places, and none of one that cannot be read: `load_scene` reports its mistakes."""
    try:
        path = resolve(scene, SCENES, "scene")
        source = load(path, str(path))
    except FileError:
        return {}
    return asked_params(source)


def asked_params(source: Map) -> dict[Scalar, Scalar]:
    """Return the `params` of a scene that was read."""
    given = source.get("params")
    pairs = given if isinstance(given, Map) else ()
    return {key: value for key, value in pairs if isinstance(value, Scalar)}
