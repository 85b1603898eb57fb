"""Contact sensitivity: maps of the error of diameters along i, along j and absolute, and what they say as numbers."""

from __future__ import annotations

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model.calibration.sensitivity import METHODS, NAME, Sensed, read_sensitivity
from stretch_bt.model.calibration.sensitivity_trends import (
    ALONG,
    ErrorBin,
    cells_of,
    depth_from,
    fine_share,
    mean_error,
    trend,
)
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.report.heatmap import Map, Tile, heatmaps
from stretch_bt.runtime.report.text import escape, number, section, table, with_sd
from stretch_bt.units import Estimate

__all__ = ["panel"]

MOST = 3.0  # mm of error at which a colour is full
DEEP = 5e-3  # m, depth from which on presses count in the mean error
NAMES = {
    "fit": "joint fit of face and skirt",
    "paper_fit": "the same, by the paper's segmentation alone",
    "paper_width": "width of the paper's segmentation",
}
_QUANTITIES = {"i": "along i", "j": "along j", "absolute": "absolute"}
_TRENDS = {"depth": "depth", "stretch": "stretch", "size": "diameter"}
NOTE = (
    "error of the diameter, blue too small, red too large, full at 3 mm; grey was refused; a frame is a mean absolute error below 1 mm; "
    "hover for numbers. A trend is the mean rank correlation of the absolute error with one quantity where the others stay, and the "
    "slope in mm a mm, each ± one standard error where more than one group of presses has a trend"
)


def panel(record: RecordReader) -> str:
    """Return the panel of a run that wrote a table of sensitivity; nothing where there is none, or no press in it."""
    path = record.folder / NAME
    if not path.exists():
        return ""
    try:
        presses = read_sensitivity(path).rows
    except InvalidInput as error:
        return section("Contact sensitivity", f"<p>{escape(error)}</p>")
    if not presses:
        return ""
    maps = {method: cells_of(presses, method) for method in METHODS}
    figures = "".join(_figure(method, quantity, cells) for method, cells in maps.items() for quantity in _QUANTITIES)
    return section("Contact sensitivity", _numbers(presses, maps) + f'<div class="grid">{figures}</div>', NOTE)


def _figure(method: str, quantity: str, cells: list[ErrorBin]) -> str:
    sizes = sorted({cell.size for cell in cells})
    maps = [
        Map(f"{number(1e3 * size)} mm", [_tile(cell, quantity) for cell in cells if cell.size == size])
        for size in sizes
    ]
    return heatmaps(f"{_QUANTITIES[quantity]}: {NAMES[method]}", "stretch, mm", "depth, mm", maps, MOST)


def _tile(cell: ErrorBin, quantity: str) -> Tile:
    value = getattr(cell, quantity)
    where = (
        f"{number(1e3 * cell.size)} mm, stretch {number(1e3 * cell.stretch)} mm, depth {number(1e3 * cell.depth)} mm"
    )
    told = f"refused {cell.refused} of {cell.presses}" if value is None else f"error {number(1e3 * value, 3)} mm"
    shown = None if value is None else 1e3 * value
    return Tile(1e3 * cell.stretch, 1e3 * cell.depth, shown, cell.fine and quantity == "absolute", f"{where}\n{told}")


def _numbers(presses: tuple[Sensed, ...], maps: dict[str, list[ErrorBin]]) -> str:
    head = (
        "method",
        "below 1 mm",
        "refused",
        f"mean error from {number(1e3 * depth_from(presses, DEEP))} mm, mm",
        *(f"with {name}" for name in _TRENDS.values()),
    )
    rows = [
        [
            escape(NAMES[method]),
            _share(cells),
            f"{sum(cell.refused for cell in cells)} of {len(presses)}",
            _mean(presses, method),
            *(_trend(cells, along) for along in ALONG),
        ]
        for method, cells in maps.items()
    ]
    return table(head, rows, range(1, len(head)))


def _share(cells: list[ErrorBin]) -> str:
    share = fine_share(cells)
    return f"{share.value:.0%} of {len(cells)}"


def _mean(presses: tuple[Sensed, ...], method: str) -> str:
    try:
        found = mean_error(presses, method, DEEP)
    except IllConditioned:
        return "–"
    return escape(with_sd(1e3 * found.value, 1e3 * found.sd))


def _trend(cells: list[ErrorBin], along: str) -> str:
    try:
        found = trend(cells, along)
    except IllConditioned:
        return "–"
    told = [found.rank] if found.slope is None else [found.rank, found.slope]
    return escape("; ".join(with_sd(v.value, v.sd) if isinstance(v, Estimate) else number(v) for v in told))
