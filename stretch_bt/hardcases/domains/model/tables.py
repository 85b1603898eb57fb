"""Tables that are wrong in a line, and protocols and conditionings that are none."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardcases.expect import Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model.calibration.characterization import PressRow, as_table, first_lines, parse_table, table_line
from stretch_bt.model.calibration.conditioning import CONDITIONED, Conditioning
from stretch_bt.model.calibration.measurements import Measurements
from stretch_bt.model.calibration.protocol import missing, protocol
from stretch_bt.model.calibration.sensitivity import METHODS, Found, Sensed, parse_sensitivity, sensed_lines
from stretch_bt.model.calibration.sensitivity import first_lines as sensitivity_lines
from stretch_bt.model.calibration.sensitivity_trends import ErrorBin, trend


def _unnumbered(name: str) -> str:
    wrong: Any = {name: math.nan}
    return table_line(replace(WRITTEN, **wrong))


def _protocol(**lengths: Any) -> Any:
    return protocol("tasks", **lengths)


HEAD = first_lines({"scene": "calibration_sphere", "seed": 3})
ROW = "sphere,20,,10,5,1,0.4,0.004,60.1,12.5\n"
#: a table and a pattern of its refusal
TABLES = {
    "nothing": ("", r":1: a table begins with '# stretch-characterization/1 '; name the file"),
    "another table": ("a,b\n1,2\n", r":1: a table begins with"),
    "half a provenance": (
        "# stretch-characterization/1 {\n",
        r":1: what the table comes from cannot be read \(it is no JSON",
    ),
    "a list of provenance": ("# stretch-characterization/1 []\n", r":1: what the table comes from is a JSON object"),
    "a provenance with NaN": (
        HEAD.replace("3", "NaN") + ROW,
        r":1: .* no JSON: NaN is no number\); restore the first line",
    ),
    "a provenance past all numbers": (HEAD.replace("3", "1e999") + ROW, r":1: .* no JSON: 1e999 is no number"),
    "no header": (HEAD.splitlines()[0] + "\n", r":2: the header of a table is geometry,"),
    "another header": (HEAD.replace("depth_mm", "depth"), r":2: the header of a table is geometry,"),
    "cut off": (HEAD + ROW + ROW[:-1], r":4: the last line has no line end, .*; remove the line, or run characterize"),
    "an empty line": (HEAD + ROW + "\n" + ROW, r":4: a row has 10 columns, this one 1"),
    "a cube": (
        HEAD + ROW.replace("sphere", "cube"),
        r":3: geometry: there is no 'cube'; write one of sphere, cylinder, cone",
    ),
    "a sphere with an angle": (
        HEAD + ROW.replace("20,,", "20,45,"),
        r":3: angle_deg: '45' stands where this geometry has none",
    ),
    "a cone with a diameter": (HEAD + ROW.replace("sphere", "cone"), r":3: diameter_mm: '20' stands where"),
    "no diameter": (HEAD + ROW.replace("20,,", ",,"), r":3: diameter_mm: '' is no finite number"),
    "a force NaN": (HEAD + ROW.replace("0.4", "nan"), r":3: force_N: 'nan' is no finite number"),
    "a force past all numbers": (HEAD + ROW.replace("0.4", "1e999"), r":3: force_N: '1e999' is no finite number"),
    "half a trial": (HEAD + ROW.replace(",5,1,", ",5,1.5,"), r":3: trial: '1.5' is no whole number"),
    "trial 0": (HEAD + ROW.replace(",5,1,", ",5,0,"), r":3: trial: 0 is below 1"),
    "a deviation below 0": (HEAD + ROW.replace("0.004", "-0.004"), r":3: force_sd_N: -0.004 is below 0"),
    "a diameter of 0": (HEAD + ROW.replace("20,,", "0,,"), r":3: the size of the indenter is 0"),
}


def _sensed(i: float = 0.021) -> Sensed:
    first = Found("fit", i, 1e-4, 0.018, 2e-4, "ellipse")
    return Sensed(
        "cylinder", 0.02, 0.01, 0.005, 1, (first, *(Found(m, 0.03, 0.0, 0.05, 0.0) for m in METHODS[1:])), 7.0
    )


def _deeper(slope: float) -> list[ErrorBin]:
    """Return places of a map whose error, m, grows with depth, m, by a slope."""
    return [ErrorBin(0.02, 0.0, d, 1, 0, e, e, e) for d in (2e-3, 6e-3, 10e-3) if (e := 1e-3 + slope * d)]


MAP = sensitivity_lines({"seed": 3}) + sensed_lines(_sensed())
MAPS = {
    "another format": (MAP.replace("stretch-sensitivity/1", "stretch-other/1"), r":1: a table begins with"),
    "half a provenance": (MAP.replace('{"seed": 3}', '{"seed"'), r":1: .* no JSON"),
    "another header": (MAP.replace("diameter_mm,", "diameter,", 1), r":2: the header"),
    "cut off in a line": (MAP[:-5], "the last press is not whole; remove its lines, or run contact_sensitivity"),
    "cut off after a line": ("\n".join(MAP.split("\n")[:-2]) + "\n", "the last press is not whole"),
    "a column less": (MAP.replace("20,10,5,1,fit", "20,10,1,fit"), r":3: a row has 15 columns"),
    "another method": (MAP.replace(",fit,", ",fitt,"), r":3: method: there is no 'fitt'"),
    "a method twice": (MAP.replace(",paper_fit,", ",paper_width,"), r":3: a press has a line for each of"),
    "lines of two presses": (
        MAP.replace("20,10,5,1,paper_fit", "20,10,6,1,paper_fit"),
        "a press has a line for each of",
    ),
    "a depth that is text": (MAP.replace("20,10,5,1,fit", "20,10,deep,1,fit"), "depth_mm: 'deep' is no finite number"),
    "half a trial": (MAP.replace("20,10,5,1,fit", "20,10,5,1.5,fit"), "trial: '1.5' is no whole number"),
    "a return within a line": (MAP.replace("ellipse", "elli\rpse"), r":3: a carriage return stands within the line"),
    "a cell without end": (MAP.replace("ellipse", "e" * 200_000), r":3: .* a cell is longer than 131072 characters"),
    "a stretch below 0": (MAP.replace("20,10,5,1,fit", "20,-10,5,1,fit"), "stretch_mm: -10 is below -1"),
}
WRITTEN = PressRow("sphere", 0.02, 0.0, 0.005, 1, 0.4, 0.004, 0.06, 1.0)
NOT_CONDITIONED: dict[str, Any] = {
    "true": True,
    "a number": 0.08,
    "nothing": {},
    "no depth": {"stretch": 0.08},
    "text": {"stretch": "80 mm", "depth": 0.01},
    "below 0": {"stretch": -1, "depth": 0.01},
}
#: changes of a press, and whether it still counts for its state
NEAR: dict[str, tuple[dict[str, Any], bool]] = {
    "0.05 mm deeper": ({"depth": 0.00505}, True),
    "0.5 mm more stretched": ({"stretch": 0.0105}, True),
    "3.5 mm deeper": ({"depth": 0.0085}, False),
    "4 mm more stretched": ({"stretch": 0.014}, False),
    "0.2 mm wider": ({"size": 0.0202}, False),
    "a cylinder": ({"geometry": "cylinder"}, False),
    "trial 6": ({"trial": 6}, False),
}


def _counts(changes: dict[str, Any]) -> bool:
    wanted = protocol("tasks", depths=[0.005, 0.006, 0.007])
    state = next(s for s in wanted.states() if (s.size, s.stretch) == (0.020, 0.010))
    return state not in missing(wanted, [replace(state, **changes)])


def _columns() -> list[float]:
    table = parse_table(HEAD + ROW + "cone,,45,0.5,0,2,0.1,0,60.1,13\n")
    columns = (
        table.size,
        table.stretch,
        table.depth,
        table.trial,
        table.force,
        table.force_sd,
        table.contact_height,
        table.time,
    )
    return [float(v) for column in columns for v in column]


SI = [0.020, math.pi / 4, 0.010, 0.0005, 0.005, 0.0, 1, 2, 0.4, 0.1, 0.004, 0.0, 0.0601, 0.0601, 12.5, 13.0]


def _again(made: Conditioning) -> bool:
    return Conditioning.of({CONDITIONED: made.to_json()}) == made


def _read(made: Conditioning | None) -> bool:
    row = PressRow("sphere", 0.02, 0.01, 0.005, 1, 0.4, 0.01, 0.05, 0.0)
    return (
        Measurements.of(as_table({} if made is None else {CONDITIONED: made.to_json()}, [row, row])).conditioned == made
    )


CASES: tuple[Hard, ...] = (
    *group(
        "a table may be cut off, or wrong in a line, which the error must name",
        {name: (partial(parse_table, text), Refusal(InvalidInput, said)) for name, (text, said) in TABLES.items()},
        {
            f"no number for {name}": (
                partial(_unnumbered, name),
                Refusal(InvalidInput, "finite"),
            )
            for name in ("force", "force_sd", "contact_height", "time", "size", "stretch", "depth")
        },
        {
            "columns in SI": (_columns, Value(SI, rel=1e-9)),
            "line ends of another system": (lambda: len(parse_table((HEAD + ROW).replace("\n", "\r\n"))), Value(1)),
        },
        prefix="table, ",
    ),
    *group(
        "a table may be cut off, or wrong in a line, which the error must name",
        {name: (partial(parse_sensitivity, text), Refusal(InvalidInput, said)) for name, (text, said) in MAPS.items()},
        {
            "no number": (lambda: sensed_lines(_sensed(math.nan)), Refusal(InvalidInput, "finite")),
            "an error that grows with depth": (lambda: trend(_deeper(0.1), "depth").slope, Value(0.1, rel=1e-9)),
            "one depth": (lambda: trend(_deeper(0.1)[:1], "depth"), Refusal(IllConditioned, "differ in depth alone")),
        },
        prefix="map of sensitivity, ",
    ),
    *group(
        "a table may say no stretch and depth of the conditioning, or wrong ones",
        {
            name: (partial(Conditioning.of, {CONDITIONED: wrong}), Refusal(InvalidInput, "conditioned: a table says"))
            for name, wrong in NOT_CONDITIONED.items()
        },
        {
            f"said again, {made}": (partial(_again, made), Value(True))
            for made in (Conditioning(), Conditioning(0.08, 0.015), Conditioning(0.0, 0.01))
        },
        {
            f"read from a table, {made}": (partial(_read, made), Value(True))
            for made in (None, Conditioning(), Conditioning(0.08, 0.015))
        },
        prefix="conditioning, ",
    ),
    *group(
        "a press counts for the state that it is near, and for no other",
        {name: (partial(_counts, changes), Value(counts)) for name, (changes, counts) in NEAR.items()},
        {
            "an unknown one": (
                partial(protocol, "papers"),
                Refusal(InvalidInput, "write one of paper, sensitivity, tasks"),
            )
        },
        {
            f"{name} {bad:g}": (
                partial(_protocol, **{name: [bad]}),
                Refusal(InvalidInput, f"{name} are finite and at least 0 m"),
            )
            for name in ("diameters", "stretches", "depths")
            for bad in (-0.001, math.nan, math.inf)
        },
        prefix="protocol, ",
    ),
)
