"""Reading scene files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, Union

from pydantic import BaseModel, ConfigDict, Discriminator, Field, PrivateAttr, Tag, create_model

from stretch_bt.errors import Diagnostic, FileError, InvalidInput, SceneError
from stretch_bt.simulation.camera.presets import PRESETS
from stretch_bt.simulation.effects import registry
from stretch_bt.simulation.effects.base import Effect
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.registry import kinds
from stretch_bt.simulation.scene.sections import USUAL, Conditions, Cup, Dimension, Hand, Table, Tolerance
from stretch_bt.source import Map, Scalar, did_you_mean, is_nothing, load, parse, resolve, told, validate
from stretch_bt.source.scene_params import SCENES, asked_params

__all__ = ["Choice", "Scene", "load_scene", "parse_scene", "scene_names", "scene_schema", "scene_text"]

_WORDS = ("auto", "none", "all")

#: a scene's choice for an effect: `auto`, `on`, `off`, or its parameters, which switch it on
Choice = Any


class Scene(BaseModel):
    """A scene file."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    format: Literal["stretch-scene/1"]
    doc: str = ""
    object: ObjectSpec
    support: Table | Cup = Field(default=Table(), discriminator="type", description="object's support: table or cup")
    hand: Hand = Hand()
    tolerance: Tolerance = Field(default=USUAL, description="tolerances that decide `effects: auto`")
    conditions: Conditions = Conditions()
    dimensions: dict[str, Dimension] = Field(
        default={},
        description="dimensions that a press from above can feel, by name, such as `length: 40 mm`; `height` counts from the table",
    )
    params: dict[str, str | int | float | bool] = Field(
        default={},
        description="params that a run in this scene begins with, such as `max_force: 0.8 N` for a weak object; params "
        "that the run sets come first, and a tree that has none of that name says so and goes without",
    )
    effects: Any = Field(
        default="auto", description="which effects act; each is judged by the advisor unless it is named"
    )
    camera: str = Field(default="bench", description="errors that the depth camera adds, before `effects` changes them")
    fidelity: Literal["hertz", "axisymmetric", "sheet", "auto"] = Field(
        default="sheet",
        description="model of the membrane; `auto` is the sheet, as finely solved as the tolerance needs",
    )
    seed: int | None = Field(default=None, ge=0, description="seed of the noise; the run's seed unless given")
    _name: str = PrivateAttr("")
    _placed_params: Mapping[Scalar, Scalar] = PrivateAttr(default_factory=dict)
    _asked: Tolerance | None = PrivateAttr(None)

    @property
    def name(self) -> str:
        """The name of its file, without the suffix."""
        return self._name

    @property
    def placed_params(self) -> Mapping[Scalar, Scalar]:
        """The params that it asks for, at their places in its file."""
        return self._placed_params

    @property
    def is_sheet(self) -> bool:
        """Whether the membrane is solved as a sheet."""
        return self.fidelity in ("sheet", "auto")

    @property
    def asked(self) -> dict[str, float]:
        """The tolerances that a run asks for in the place of the scene's own, SI."""
        return {} if self._asked is None else self._asked.named()

    @property
    def kept(self) -> dict[str, float]:
        """The tolerances of the scene that hold beside those asked for, SI."""
        own = {} if self.asked and "tolerance" not in self.model_fields_set else self.tolerance.named()
        return {name: value for name, value in own.items() if name not in self.asked}

    def tolerating(self, asked: Tolerance) -> Scene:
        """Return the same scene for a run that asks for a tolerance: it replaces the scene's tolerances of the results that it names.

        A tolerance that the scene has only by default no longer counts.
        """
        made = self.with_()
        made._asked = asked
        return made

    def choice(self, effect: str) -> Choice:
        """Return the scene's choice for an effect: `auto`, `on`, `off`, or its parameters."""
        if isinstance(self.effects, str):
            return {"auto": "auto", "none": "off", "all": "on"}[self.effects]
        return getattr(self.effects, effect)

    def parameters(self, effect: type[Effect]) -> Any:
        """Return the parameters of an effect: the scene's, else the camera preset's, else the usual ones."""
        choice = self.choice(effect.name)
        if isinstance(choice, effect.Parameters):
            return choice
        return PRESETS[self.camera].get(effect.name) or effect.Parameters()

    def camera_adds(self, effect: str) -> bool:
        """Return whether the camera preset adds an effect."""
        return effect in PRESETS[self.camera]

    def stands_in(self) -> bool:
        """Return whether the scene's fidelity has an answer to its object."""
        form = self.object.hertz
        if self.is_sheet:
            return self.object.body() is not None
        return form is not None and (self.fidelity == "hertz" or form.kind == "sphere")

    def with_(self, **changes: Any) -> Scene:
        """Return the same scene with other fields."""
        return self.model_copy(update=changes)


@lru_cache(maxsize=1)
def _model() -> type[Scene]:
    """Return the model of scene files with every kind of object and effect that there is."""
    described = {name: field.description for name, field in Scene.model_fields.items()}
    chosen: dict[str, Any] = {
        name: (_choice(effect), Field(default="auto", description=_first(effect)))
        for name, effect in registry().items()
    }
    effects: Any = create_model(
        "Effects",
        __config__=ConfigDict(extra="forbid", strict=True, frozen=True),
        __doc__="Effects by name: `auto`, `on`, `off`, or parameters, which switch it on.",
        **chosen,
    )
    union: Any = Union[tuple(kinds().values())]  # noqa: UP007
    fields: dict[str, Any] = {
        "object": (Annotated[union, Field(discriminator="type")], ...),
        "effects": (_word_or(Literal[_WORDS], effects), Field(default="auto", description=described["effects"])),
        "camera": (Literal[tuple(PRESETS)], Field(default="bench", description=described["camera"])),
    }
    return create_model("Scene", __base__=Scene, __doc__="A scene file.", **fields)


def _choice(effect: type[Effect]) -> Any:
    words = Literal["auto", "on", "off"]
    return _word_or(words, effect.Parameters) if effect.Parameters.model_fields else words


def _word_or(words: Any, mapping: type[BaseModel]) -> Any:
    """Return the type of a value that is one of some words or a mapping; a mistake in one is reported without the other."""
    return Annotated[
        Annotated[words, Tag("word")] | Annotated[mapping, Tag("mapping")],
        Discriminator(lambda given: "word" if isinstance(given, str) else "mapping"),
    ]


def _first(effect: type[Effect]) -> str:
    return (effect.__doc__ or "").partition("\n")[0]


def load_scene(scene: str | Path) -> Scene:
    """Read a scene file, or a shipped scene by its name.

    Raises
    ------
    SceneError
        With every mistake at its line and column.
    """
    try:
        path = resolve(scene, SCENES, "scene")
        source = load(path, str(path))
    except FileError as error:
        raise SceneError(error.diagnostics) from None
    return _made(source, path)


def scene_text(scene: str | Path) -> str:
    """Return the text of a scene file, or of a shipped scene by its name."""
    return resolve(scene, SCENES, "scene").read_text("utf-8")


def parse_scene(text: str, name: str = "scene.yaml") -> Scene:
    """Read the text of a scene file, with the errors of `load_scene`."""
    try:
        source = parse(text, name)
    except FileError as error:
        raise SceneError(error.diagnostics) from None
    if not isinstance(source, Map):
        raise SceneError([source.mark.error("value", "a scene is a mapping", "write 'format: stretch-scene/1' first")])
    return _made(source, Path(name))


def scene_names() -> list[str]:
    """Return the names of the shipped scenes."""
    return sorted(path.stem for path in SCENES.glob("*.yaml"))


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema of scene files."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_model().model_json_schema()}


def _made(source: Map, path: Path) -> Scene:
    words = list(_wrong_words(source))
    try:
        made = _located(validate(_model(), source), source, path)
    except FileError as error:
        places = {(d.line, d.column) for d in words}
        others = [d for d in error.diagnostics if (d.line, d.column) not in places]
        raise SceneError(sorted([*words, *others], key=lambda d: (d.line, d.column))) from None
    if words:
        raise SceneError(words)
    found = list(_impossible(made, source))
    if found:
        raise SceneError(found)
    made._name, made._placed_params = path.stem, asked_params(source)
    return made


def _located(scene: Scene, source: Map, path: Path) -> Scene:
    """Return the scene with the files that its object names found next to its own, and its shape made once."""
    try:
        return scene.with_(object=scene.object.located(path.parent))
    except InvalidInput as error:
        given = source.get("object") or source
        named = given.get("file") if isinstance(given, Map) else None
        message, _, hint = str(error).partition("; ")
        hint = hint or "write sizes, or a file, that make one closed surface"
        raise FileError([(named or given).mark.error("value", f"object: {message}", hint)]) from None


def _wrong_words(source: Map) -> Iterator[Diagnostic]:
    """Yield each unknown kind of object or word at its own place; pydantic would point at the whole union."""
    for section, known in (("object", tuple(kinds())), ("support", ("table", "cup"))):
        given = source.get(section)
        kind = given.get("type") if isinstance(given, Map) else None
        if kind is None or is_nothing(kind):
            continue
        if not isinstance(kind, Scalar):
            yield kind.mark.error(
                "value", f"{section}.type takes one word, not {told(kind)}", f"write one of {', '.join(known)}"
            )
        elif kind.plain() not in known:
            hint = did_you_mean(kind.text, known)
            yield kind.mark.error("value", f"{section}.type: there is no {told(kind)}", hint)
    given = source.get("effects")
    if isinstance(given, Scalar) and not is_nothing(given) and given.plain() not in _WORDS:
        hint = f"write one of {', '.join(_WORDS)}, or a mapping"
        yield given.mark.error("value", f"effects: {given.text!r} is none", hint)
    for key, value in given if isinstance(given, Map) else ():
        if is_nothing(value) or not isinstance(value, Scalar) or key.text not in registry():
            continue
        if value.plain() not in ("auto", "on", "off"):
            message = f"effects.{key.text} takes auto, on, off or its parameters, not {value.text!r}"
            yield value.mark.error("value", message, did_you_mean(value.text, ("auto", "on", "off")) or "write on")


def _impossible(scene: Scene, source: Map) -> Iterator[Diagnostic]:
    """Yield an error for each thing that the object, the fidelity and the support of a scene cannot have together."""
    given = source.get("effects")
    for key, _ in given if isinstance(given, Map) else ():
        effect = registry()[key.text]
        reason = effect.refusal(scene.object) or effect.not_at(scene)
        if scene.choice(key.text) not in ("auto", "off") and reason is not None:
            yield key.mark.error("effect-impossible", f"effects.{key.text}: {reason}", _able(scene, effect))
    fidelity, support = source.get("fidelity"), source.get("support")
    if not scene.stands_in():
        message = f"fidelity: nothing stands in for {scene.object.noun} at {scene.fidelity} fidelity"
        known = "sheet" if scene.object.body() is not None else "hertz"
        place = fidelity or source.get("object") or source
        yield place.mark.error("value", message, f"write 'fidelity: {known}'")
    if isinstance(scene.support, Cup) and scene.support.rim >= scene.object.top and isinstance(support, Map):
        message = "support.rim: the rim of the cup is as high as the object's top, so that the hand does not reach it"
        yield support.mark.error("value", message, "raise the object's base, or lower the rim")


def _able(scene: Scene, effect: type[Effect]) -> str:
    if effect.group != "object":
        return "write fidelity: sheet, or leave it out"
    able = [name for name, e in registry().items() if e.group == "object" and e.refusal(scene.object) is None]
    return f"of the object's own effects it can have {', '.join(able)}" if able else "it has no effects of its own"
