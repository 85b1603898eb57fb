"""A drawing that any browser shows, without Graphviz."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.tree.export.escape import xml
from stretch_bt.tree.export.layout import CHAR, GAP_X, HEADING, LINE, PAD, NodeBox, arrange
from stretch_bt.tree.export.style import colour, fill, legend
from stretch_bt.tree.export.view import views
from stretch_bt.tree.program import Program

__all__ = ["drawing", "write"]

MARGIN = 24.0
BAND = 4.0
ROUND = 6.0

_STYLE = """
.bt text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif;fill:#1c2430}
.bt .h{font-size:13px;font-weight:600}.bt .t{font-size:17px;font-weight:650}.bt .k{font-size:11px;fill:#5b6675}
.bt .m{font-family:ui-monospace,SFMono-Regular,Menlo,Consolas,"DejaVu Sans Mono",monospace;font-size:11px}
.bt .m tspan{fill:#5b6675}.bt .w{fill:#9a5d00}
.bt .e{fill:none;stroke:#aab3bf;stroke-width:1.3}.bt .f{stroke-dasharray:4 3}
"""


def write(program: Program) -> str:
    """Return the drawing as a file."""
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{drawing(program)}\n'


def drawing(program: Program, titled: bool = True) -> str:
    """Return the drawing as an element, with the file's name over it or without."""
    top = MARGIN + (30.0 if titled else 0.0)
    boxes, right, bottom = arrange(views(program), MARGIN, top)
    every = [box for root in boxes for box in root.walk()]
    width = max(right + MARGIN, 640.0)
    height = bottom + 26.0
    name = xml(program.document.file)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="bt" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" role="img"><title>{name}</title><style>{_STYLE}</style>',
        f'<rect width="{width:.0f}" height="{height:.0f}" fill="#fff"/>',
        f'<text class="t" x="{MARGIN:g}" y="{MARGIN + 10:g}">{name}</text>' if titled else "",
        *(line for box in every for line in _edges(box)),
        *(text for box in every for text in _box(box)),
        *_legend({box.view.kind for box in every}, height - MARGIN / 2),
        "</svg>",
    ]
    return "\n".join(part for part in parts if part)


def _edges(box: NodeBox) -> Iterator[str]:
    """Yield the lines to the children, with round corners; a dashed one leads to `finally`."""
    for child in box.children:
        x0, y0, x1, y1 = box.x + box.width, box.anchor, child.x, child.anchor
        bend = x1 - GAP_X / 2
        r = min(ROUND, abs(y1 - y0) / 2)
        turn = r if y1 > y0 else -r
        path = f"M{x0:.1f} {y0:.1f}H{bend - r:.1f}q{r:.1f} 0 {r:.1f} {turn:.1f}V{y1 - turn:.1f}q0 {turn:.1f} {r:.1f} {turn:.1f}H{x1:.1f}"
        yield f'<path class="e{" f" if child.is_finally else ""}" d="{path}"/>'
        if child.is_finally:
            yield f'<text class="k" x="{bend + 4:.1f}" y="{child.y - 2:.1f}">finally</text>'


def _box(box: NodeBox) -> Iterator[str]:
    x, y, band = box.x, box.y, colour(box.view.kind)
    yield f"<g><title>{xml(_tooltip(box))}</title>"
    yield (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{box.width:.1f}" height="{box.height:.1f}" rx="{ROUND:g}" '
        f'fill="{fill(box.view.kind)}" stroke="{band}" stroke-opacity=".45"/>'
    )
    yield f'<rect x="{x:.1f}" y="{y + 3:.1f}" width="{BAND:g}" height="{box.height - 6:.1f}" rx="2" fill="{band}"/>'
    row = y + PAD / 2
    for text in box.around:
        yield f'<text class="m w" x="{x + PAD:.1f}" y="{row + 11:.1f}">{xml(text)}</text>'
        row += LINE
    yield f'<text class="h" x="{x + PAD:.1f}" y="{row + 14:.1f}">{xml(box.heading)}</text>'
    row += HEADING
    for name, value in box.lines:
        yield (
            f'<text class="m" x="{x + PAD:.1f}" y="{row + 11:.1f}"><tspan>{xml(name)}</tspan>'
            f'<tspan x="{x + PAD + CHAR * (len(name) + 2):.1f}" style="fill:#1c2430">{xml(value)}</tspan></text>'
        )
        row += LINE
    yield "</g>"


def _tooltip(box: NodeBox) -> str:
    view = box.view
    around = [f"{path}: {text}" for text, path in view.around]
    settings = [f"{name}: {value}" for name, value in view.settings.items()]
    merged = [f"{box.merged.path} ({box.merged.keyword})"] if box.merged else []
    return "\n".join([view.path, *([view.doc] if view.doc else []), *around, *settings, *merged])


def _legend(kinds: set[str], y: float) -> Iterator[str]:
    x = MARGIN
    for kind, name in legend(kinds):
        yield f'<rect x="{x:.1f}" y="{y - 9:.1f}" width="10" height="10" rx="2" fill="{colour(kind)}"/>'
        yield f'<text class="k" x="{x + 15:.1f}" y="{y:.1f}">{name}</text>'
        x += 15 + 7 * len(name) + 18
