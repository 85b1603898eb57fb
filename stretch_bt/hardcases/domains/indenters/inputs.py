"""Indenters as people write and place them: misspelt, without unit, of no size, tilted too far."""

from __future__ import annotations

import math
from functools import partial

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.expect import Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.parse import parse_indenter
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.turned import turn

RIGHT = {
    "sphere:20mm": Sphere(0.02),
    "cylinder: 20 mm": Cylinder(0.02),
    "cylinder:2cm:0.5mm": Cylinder(0.02, 0.0005),
    "cone:45deg": Cone(math.pi / 4),
    "cone:45deg:1mm": Cone(math.pi / 4, 0.001),
    "cube:40mm": Cube(0.04),
}
WRONG = {
    "spere:20mm": "did you mean sphere",
    "sphere": "sphere:20mm",
    "sphere:20": "20 mm",
    "sphere:20mm:1mm": "sizes",
    "cube:-4mm": "above 0",
    "cube:1mm": "at least 2 mm",
    "cylinder:1mm": "a smaller one too",
    "cone:95deg": "below",
    "cylinder:2mm:3mm": "at most",
    "cone:45mm": "Angle",
    "": "choose",
}
BALL = Sphere(0.02)

CASES: tuple[Hard, ...] = (
    *group(
        "a text may have blanks, other units and sizes left out",
        {f"text {text!r}": (partial(parse_indenter, text), Value(shape)) for text, shape in RIGHT.items()},
    ),
    *group(
        "a text that names no indenter must say what to write",
        {
            f"text {text!r}": (partial(parse_indenter, text), Refusal(InvalidInput, said))
            for text, said in WRONG.items()
        },
    ),
    *group(
        "numbers that make no place or no turn",
        {
            "a place that is no number": (
                partial(place, BALL, (math.nan, 0.0), (0.0, 0.0), 0.01),
                Refusal(InvalidInput, "finite numbers"),
            ),
            "a tilt of more than 90 degrees": (
                partial(place, BALL, (0.0, 0.0), (1.6, 0.0), 0.01),
                Refusal(InvalidInput, "within 90 degrees"),
            ),
            "a cone tilted past its flank": (
                partial(place, Cone(0.3), (0.0, 0.0), (0.4, 0.0), 0.01),
                Refusal(InvalidInput, "flank"),
            ),
            "an endless turn": (partial(turn, Cube(0.02), math.inf), Refusal(InvalidInput)),
        },
    ),
)
