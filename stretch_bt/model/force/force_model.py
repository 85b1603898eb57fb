"""The interface of every force law of the hand, whatever stands behind it."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any, ClassVar, Protocol, runtime_checkable

from stretch_bt.arguments import check_numbers, check_path
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.plain_numbers import is_number
from stretch_bt.quantity_text import format_apart
from stretch_bt.source.bounds import read_bytes
from stretch_bt.source.strict_json import read_json
from stretch_bt.units import KINDS, Estimate

__all__ = [
    "FITTED",
    "FITTED_FILE",
    "FORMAT",
    "PAPER",
    "SHIPPED",
    "ForceModel",
    "Range",
    "change_by_size",
    "check_model",
    "model_of_kind",
    "require_force",
    "shipped",
]

FORMAT = "stretch-calibration/1"
_KINDS = {
    "calibrated_hertz": "stretch_bt.model.force.calibrated:CalibratedHertz",
    "membrane": "stretch_bt.model.force.membrane:MembraneModel",
    "sheet": "stretch_bt.simulation.sheet_model:SheetModel",
}
#: the shipped calibration of the paper's model
PAPER = "paper"
#: name of the model that `fit_calibration` fitted in a run, and of its file in the record of the run
FITTED, FITTED_FILE = "fitted", "calibration.json"
#: shipped models by name: the file, and the kind to read it as
SHIPPED = {
    PAPER: ("default_calibration", "calibrated_hertz"),
    "membrane": ("default_membrane", "membrane"),
    "sheet": ("default_membrane", "sheet"),
}
_LENGTH = KINDS["Length"]
#: m; largest end of each range in a calibration file
MOST = {"radius": 1.0, "stretch": 0.2, "depth": 0.1}
#: m; tolerance of where gripper and arm stand, about where they were sent
STRETCH_OFF, DEPTH_OFF = 1e-3, 2e-4
_SAME = 1e-6
#: remedy for a value outside the range, by its name and whether it is too large
_REMEDIES = {
    (
        "radius",
        True,
    ): "no sphere that the model knows is so nearly flat; press where the object is round, or calibrate with larger spheres",
    (
        "radius",
        False,
    ): "no sphere that the model knows is so sharp; press where the object is rounder, or calibrate with smaller spheres",
    ("stretch", True): "stretch the membrane less, or calibrate at larger stretches",
    ("stretch", False): "stretch the membrane further, or calibrate at smaller stretches",
    ("depth", True): "press less deep, or calibrate deeper",
    ("depth", False): "press deeper, or calibrate from first contact on",
}


@dataclass(frozen=True, slots=True)
class Range:
    """Where a force model holds, SI, both ends allowed."""

    radius: tuple[float, float]
    stretch: tuple[float, float]
    depth: tuple[float, float]

    def check(self, **values: float) -> None:
        """Raise InvalidInput, saying the range, when a named value lies outside it."""
        check_numbers("in m", **values)
        for name, value in values.items():
            low, high = getattr(self, name)
            if not low <= value <= high:
                asked, least, most = format_apart(_LENGTH, value, low, high)
                remedy = _REMEDIES[name, value > high]
                raise InvalidInput(f"{name} {asked} is outside the calibrated range, {least} to {most}: {remedy}")

    def holds(self, radius: float, stretch: float, depth: float) -> bool:
        """Return whether a place lies inside, within the tolerance of where arm and gripper stand."""
        check_numbers("in m", radius=radius, stretch=stretch, depth=depth)
        places = ((self.radius, radius, _SAME), (self.stretch, stretch, STRETCH_OFF), (self.depth, depth, DEPTH_OFF))
        return all(low - off <= value <= high + off for (low, high), value, off in places)

    def to_json(self) -> dict[str, list[float]]:
        """Return the ends, SI, by name."""
        return {name: list(ends) for name, ends in asdict(self).items()}

    @classmethod
    def from_json(cls, fields: Any, name: str = "range") -> Range:
        """Return the range of a calibration file, in which it is called `name`."""
        if not isinstance(fields, dict) or set(fields) != set(MOST):
            raise InvalidInput(f"{name}: it has the ends of {', '.join(MOST)}, m, not {fields!r}")
        for key, most in MOST.items():
            ends = fields[key]
            numbers = isinstance(ends, list) and len(ends) == 2 and all(map(is_number, ends))
            if not (numbers and 0 <= ends[0] <= ends[1] <= most):
                raise InvalidInput(f"{name}.{key}: its ends are numbers that rise, from 0 to {most:g} m, not {ends!r}")
        return cls(**{key: (float(low), float(high)) for key, (low, high) in fields.items()})


class ForceModel(ABC):
    """The force of the hand on a sphere as a function of the sphere's radius, the stretch and the depth.

    Lengths in m, forces in N. Each method raises InvalidInput outside the model's `range`, and the inverses raise
    NoEquilibrium when nothing within the range gives the force.
    """

    kind: ClassVar[str]
    range: Range
    relative_sd: float
    provenance: dict[str, Any]
    #: the measured range, where the model also answers beyond it
    measured: Range | None = None

    @abstractmethod
    def predict(self, radius: float, stretch: float, depth: float) -> tuple[float, float]:
        """Return the force and its standard deviation."""

    @abstractmethod
    def depth_for(self, radius: float, stretch: float, force: float) -> float:
        """Return the depth at which the force is this one; exact inverse of `predict`."""

    @abstractmethod
    def stretch_for(self, radius: float, depth: float, force: float) -> float:
        """Return the stretch at which the force is this one; exact inverse of `predict`."""

    def in_range(self, radius: float, stretch: float, depth: float) -> bool:
        """Return whether forces were measured around there; the model may answer beyond, with a larger deviation."""
        return (self.measured or self.range).holds(radius, stretch, depth)

    def deepest(self, radius: float, stretch: float) -> float:
        """Return the deepest press, m, that the model answers for."""
        return self.range.depth[1]

    def hang(self, stretch: float) -> Estimate | None:
        """Return the sag of the free membrane in its middle, m, at a stretch, m; None where the model knows nothing of it."""
        return None

    @property
    def prestretch(self) -> Estimate:
        """By how much the mounts stretch the membrane at stretch 0, m; 0 where the model knows nothing of it."""
        return Estimate(0.0, 0.0)

    @abstractmethod
    def to_json(self) -> dict[str, Any]:
        """Return the parameters, SI, for `save`."""

    @classmethod
    @abstractmethod
    def from_json(cls, fields: dict[str, Any]) -> ForceModel:
        """Return the model with these parameters."""

    def save(self, path: str | Path) -> None:
        """Write the parameters, their standard deviations, the range and the provenance to a JSON file.

        Raises
        ------
        InvalidInput
            The path is none, or a number of the provenance is not finite.
        """
        check_path(path)
        try:
            text = json.dumps({"format": FORMAT, "kind": self.kind, **self.to_json()}, indent=2, allow_nan=False)
        except ValueError:
            raise InvalidInput(
                "the provenance has a number that is not finite; leave it out, or write it as text"
            ) from None
        Path(path).write_text(text + "\n", encoding="utf-8")

    @staticmethod
    def load(path: str | Path) -> ForceModel:
        """Read a model that `save` wrote, of whatever kind, or a shipped one by its name.

        Raises
        ------
        InvalidInput
            The file is missing or is not a calibration.
        """
        check_path(path)
        if str(path) in SHIPPED:
            return shipped(str(path))
        try:
            return _decode(read_bytes(Path(path)).decode())
        except OSError as error:
            names = ", ".join(SHIPPED)
            raise InvalidInput(
                f"{path}: the calibration cannot be read ({error.strerror}); name a file that calibrate wrote, or one of {names}"
            ) from None
        except InvalidInput as error:
            raise InvalidInput(f"{path}: {error}; restore the file, or calibrate again") from None
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise InvalidInput(f"{path}: this is not a calibration ({error})") from None

    @staticmethod
    def default() -> ForceModel:
        """Return the shipped calibration of the paper's model: an assumption fitted to two figures of the paper, not a measurement."""
        return shipped(PAPER)


def shipped(name: str) -> ForceModel:
    """Return a shipped model: `paper`, or a model of the twin's own hand, `membrane` from the table and `sheet` by solving.

    Raises
    ------
    InvalidInput
        There is no such model.
    """
    if not isinstance(name, str) or name not in SHIPPED:
        raise InvalidInput(
            f"no shipped model {shown(name)[:80]}; name one of {', '.join(SHIPPED)}, or a calibration file"
        )
    file, kind = SHIPPED[name]
    return _decode(files("stretch_bt.model").joinpath(f"data/{file}.json").read_text("utf-8"), kind)


def _decode(text: str, kind: str | None = None) -> ForceModel:
    """Return the model of a text, as the kind that is named or that it names itself."""
    fields = read_json(text)
    if not isinstance(fields, dict) or fields.get("format") != FORMAT:
        raise ValueError(f"its format is not {FORMAT!r}")
    if fields.get("kind") not in _KINDS:
        raise ValueError(f"its kind {fields.get('kind')!r} is not one of {', '.join(_KINDS)}")
    return model_of_kind(kind or fields["kind"]).from_json(fields)


def model_of_kind(kind: str) -> type[ForceModel]:
    """Return the class of a kind of model; its module is imported only now."""
    module, _, name = _KINDS[kind].partition(":")
    found: type[ForceModel] = getattr(import_module(module), name)
    return found


def require_force(force: float) -> None:
    """Raise InvalidInput unless the force is a finite number of N, 0 or more."""
    if not (is_number(force) and force >= 0):
        raise InvalidInput(f"force must be finite and at least 0 N, not {shown(force)[:80]}")


def change_by_size(model: ForceModel, radius: Estimate, stretch: float, depth: float) -> float:
    """Return by how much the force, N, changes with a radius, m, one deviation smaller, or larger where the model ends before."""
    force = model.predict(radius.value, stretch, depth)[0]
    least, most = model.range.radius
    try:
        if radius.value - radius.sd >= least:
            return abs(model.predict(radius.value - radius.sd, stretch, depth)[0] - force)
    except InvalidInput:  # the membrane would wrap around so small a sphere
        pass
    return abs(model.predict(min(radius.value + radius.sd, most), stretch, depth)[0] - force)


@runtime_checkable
class _Law(Protocol):
    """The part of a model that is used: a class of the caller's own needs no more."""

    range: Range

    def predict(self, radius: float, stretch: float, depth: float) -> tuple[float, float]: ...


def check_model(model: object) -> None:
    """Raise InvalidInput unless an object predicts forces, and has a range."""
    if not isinstance(model, _Law):
        raise InvalidInput(
            f"model is a ForceModel, not {shown(model)[:80]}; `ForceModel.load` and `ForceModel.default` give one"
        )
