"""Scene files: what the twin simulates."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, model_validator

from stretch_bt.errors import FileError, InvalidInput, SceneError
from stretch_bt.source import Map, did_you_mean, load, resolve, validate
from stretch_bt.units import Force, Length, Stiffness, Within

__all__ = [
    "CameraNoise",
    "CylinderObject",
    "ForceNoise",
    "PlaneObject",
    "Point",
    "RobotErrors",
    "Scene",
    "SphereObject",
    "load_scene",
    "scene_names",
    "scene_schema",
]

FORMAT = "stretch-scene/1"
_Stiff = Annotated[Stiffness, Within(1.0, 1e7, "Stiffness")]
_Height = Annotated[Length, Within(0.0, 0.5, "Length")]
_Noise = Annotated[Length, Within(0.0, 0.05, "Length")]
_ForceNoise = Annotated[Force, Within(0.0, 50.0, "Force")]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Point(_Model):
    """A place on the table, world x and y, m."""

    x: Annotated[Length, Within(-1.0, 1.0, "Length")] = 0.0
    y: Annotated[Length, Within(-1.0, 1.0, "Length")] = 0.0


class _Object(_Model):
    stiffness: _Stiff | None = Field(default=None, description="force per height lost, of a linearly elastic object")
    rigid: bool = Field(default=False, description="true for an object that does not give way")
    position: Point = Field(default=Point(), description="where its axis stands on the table")
    base: _Height = Field(default=0.0, description="height of its lowest point above the table")

    @model_validator(mode="after")
    def _one_law(self) -> _Object:
        if self.rigid == (self.stiffness is not None):
            raise InvalidInput(
                "an object is either elastic or rigid; write one of 'stiffness: 0.9 N/mm' and 'rigid: true'"
            )
        return self


class SphereObject(_Object):
    """A sphere, fixed where it stands."""

    type: Literal["sphere"]
    diameter: Annotated[Length, Within(0.005, 0.080, "Length")]


class CylinderObject(_Object):
    """An upright cylinder with a flat end."""

    type: Literal["cylinder"]
    diameter: Annotated[Length, Within(0.005, 0.080, "Length")]
    height: Annotated[Length, Within(0.001, 0.5, "Length")]


class PlaneObject(_Object):
    """A block with a flat, level top that is wider than the membrane."""

    type: Literal["plane"]
    height: Annotated[Length, Within(0.001, 0.5, "Length")]


class CameraNoise(_Model):
    """What the camera adds to the depth that it sees."""

    noise: _Noise = Field(
        default=0.0002, description="standard deviation of white noise, independent between pixels and frames"
    )
    quantisation: Annotated[Length, Within(0.000001, 0.01, "Length")] = Field(
        default=0.000125, description="one count of depth"
    )
    dropout: Annotated[float, Within(0.0, 1.0)] = Field(
        default=0.0, description="part of the pixels without a value, 0 to 1"
    )


class RobotErrors(_Model):
    """How far the arm is from where it says it is, and how well it feels force."""

    repeatability: _Noise = Field(default=0.0, description="standard deviation of the height that each move ends at")
    force_noise: _ForceNoise = Field(
        default=0.1, description="standard deviation of the arm's own force estimate, an axis"
    )


class ForceNoise(_Model):
    """Noise of the force sensor."""

    noise: _ForceNoise = Field(default=0.02, description="standard deviation, an axis")


class Scene(_Model):
    """A scene file."""

    format: Literal["stretch-scene/1"]
    doc: str = ""
    object: SphereObject | CylinderObject | PlaneObject = Field(discriminator="type")
    fidelity: Literal["hertz"] = "hertz"
    camera: CameraNoise = CameraNoise()
    robot: RobotErrors = RobotErrors()
    force_sensor: ForceNoise = ForceNoise()
    seed: int | None = Field(default=None, ge=0, description="seed of the noise; that of the run unless given")
    _name: str = PrivateAttr("")

    @property
    def name(self) -> str:
        """The name of its file, without the suffix."""
        return self._name


def load_scene(scene: str | Path) -> Scene:
    """Read a scene file, or a shipped scene by its name.

    Raises
    ------
    SceneError
        With every mistake at its line and column.
    """
    try:
        path = resolve(scene, _shipped(), "scene")
        source = load(path, str(path))
        _check_type(source)
        made = validate(Scene, source)
    except FileError as error:
        raise SceneError(error.diagnostics) from None
    made._name = path.stem
    return made


def scene_names() -> list[str]:
    """Return the names of the shipped scenes."""
    return sorted(path.stem for path in _shipped().glob("*.yaml"))


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema of scene files."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Scene.model_json_schema()}


def _shipped() -> Path:
    return Path(str(files("stretch_bt") / "trees" / "scenes"))


def _check_type(source: Map) -> None:
    """Refuse an unknown kind of object at its own place; pydantic would point at the whole object."""
    given = source.get("object")
    kind = given.get("type") if isinstance(given, Map) else None
    known = ("sphere", "cylinder", "plane")
    if kind is not None and kind.plain() not in known:
        message = f"object.type: there is no {kind.plain()!r}"
        raise FileError([kind.mark.error("value", message, did_you_mean(str(kind.plain()), known))])
