"""Indenters as people write them: `sphere:20mm`, `cylinder:20mm:1mm`, `cone:45deg:0.5mm`, `cube:40mm`, `height:part.npy:0.5mm`."""

from __future__ import annotations

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.source import closest
from stretch_bt.units import KINDS

__all__ = ["parse_indenter"]

_FORMS = {
    "sphere": "sphere:20mm, a diameter",
    "cylinder": "cylinder:20mm or cylinder:20mm:1mm, a diameter and a rim fillet",
    "cone": "cone:45deg or cone:45deg:0.5mm, the angle to the membrane plane and a tip radius",
    "cube": "cube:40mm, the side of its face",
    "height": "height:part.npy:0.5mm, a file of heights in m over a square grid, and its pitch",
}

_SMALLEST = 2e-3  # m; a cube or cylinder that has just room for the fillet that it gets


def parse_indenter(text: str) -> Indenter:
    """Return the indenter that a text such as `sphere:20mm` names.

    Raises
    ------
    InvalidInput
        The name, the number of sizes or a unit is wrong; the text says what to write.
    """
    name, *sizes = (part.strip() for part in text.split(":"))
    if name not in _FORMS:
        near = closest(name, _FORMS)
        hint = f"; did you mean {near}?" if near else ""
        raise InvalidInput(f"{name!r} is no indenter; choose from {', '.join(_FORMS)}{hint}")
    if name == "height":
        return _field(text, sizes)
    most = 1 if name in ("sphere", "cube") else 2
    if not 1 <= len(sizes) <= most:
        raise InvalidInput(f"{text!r} has {len(sizes)} sizes; write {_FORMS[name]}")
    if name == "cone":
        angle, tip = KINDS["Angle"].parse(sizes[0]), [KINDS["Length"].parse(s) for s in sizes[1:]]
        return Cone(angle, *tip)
    lengths = [KINDS["Length"].parse(size) for size in sizes]
    if name == "cube" and 0 < lengths[0] < _SMALLEST:
        raise InvalidInput(
            f"{text!r} has no room for its edge fillets of 1 mm: write a side of at least 2 mm, or give it smaller ones in "
            f"Python, as in Cube({lengths[0]:g}, edge={lengths[0] / 4:g})"
        )
    if name == "cylinder" and len(lengths) == 1 and 0 < lengths[0] < _SMALLEST:
        raise InvalidInput(
            f"{text!r} has no room for a rim fillet of 1 mm: write a smaller one too, as in {text}:{lengths[0] * 250:g}mm"
        )
    if name == "sphere":
        return Sphere(*lengths)
    return Cylinder(*lengths) if name == "cylinder" else Cube(*lengths)


def _field(text: str, parts: list[str]) -> HeightField:
    """Return the height field of a file, whose name may hold colons."""
    if len(parts) < 2:
        raise InvalidInput(f"{text!r} has no pitch; write {_FORMS['height']}")
    return HeightField.load(":".join(parts[:-1]), KINDS["Length"].parse(parts[-1]))
