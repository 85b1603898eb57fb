"""What a person sees while a tree runs: the tree with what each node is doing, or one line a change without a terminal."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

__all__ = ["LiveView"]

Outline = Sequence[tuple[int, str, str]]

_MARKS = {"RUNNING": ("▶", "bold cyan"), "SUCCESS": ("✓", "green"), "FAILURE": ("✗", "red"), "INVALID": ("·", "dim")}
_IDLE = ("·", "dim")
_UNSEEN = ("INVALID", "")
_WORDS = {"INVALID": "interrupted"}
PERIOD = 0.1  # s of wall time between drawings


class LiveView:
    """Shows a run on a console, by default standard error.

    On a terminal it redraws the tree a few times a second, cut to the rows around what runs. Elsewhere it prints a line
    whenever an action, a node without children, changes its status. It gets the changes by `update`.
    """

    def __init__(self, console: Console | None = None) -> None:
        self._console = console or Console(stderr=True)
        self._outline: Outline = ()
        self._actions: frozenset[str] = frozenset()
        self._shown: dict[str, tuple[str, str]] = {}
        self._now = 0.0
        self._live: Live | None = None

    def start(self, tree_outline: Outline) -> None:
        """Begin to show a tree: (depth, path, label) of each node, parents before children."""
        self._outline = tree_outline
        self._actions = _leaves(tree_outline)
        self._shown = {}
        self._now = 0.0
        if self._console.is_terminal:
            self._live = Live(
                get_renderable=self._draw,
                console=self._console,
                refresh_per_second=1 / PERIOD,
                transient=True,
                redirect_stdout=sys.stdout.isatty(),  # what is piped on stays where it was sent
            )
            self._live.start()

    def update(self, now: float, statuses: Mapping[str, tuple[str, str]]) -> None:
        """Show the task time, s, and the status and text of each node by path; may be called on every tick."""
        self._now = now
        for path, (status, text) in statuses.items():
            self._show(path, status, text)

    def _show(self, path: str, status: str, text: str) -> None:
        before = self._shown.get(path, _UNSEEN)[0]
        self._shown[path] = status, text
        if self._live is None and path in self._actions and status != before:
            self._print(path, status, text)

    def stop(self) -> None:
        """End; the last picture of the tree stays on a terminal. May be called more than once."""
        if self._live is not None:
            live, self._live = self._live, None
            live.stop()
            self._console.print(Group(*self._lines(range(len(self._outline)))))

    def _print(self, path: str, status: str, text: str) -> None:
        line = f"{self._now:9.2f} s  {_WORDS.get(status, status.lower()):<11} {path}" + (f"  {text}" if text else "")
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)

    def _draw(self) -> RenderableType:
        rows = _window([self._shown.get(path, _UNSEEN)[0] for _, path, _ in self._outline], self._console.height - 2)
        clock = Text.assemble(("task time ", "dim"), (f"{self._now:.1f} s", "bold"))
        return Group(clock, *self._lines(rows))

    def _lines(self, rows: range) -> list[Text]:
        return [self._line(*self._outline[row]) for row in rows]

    def _line(self, depth: int, path: str, label: str) -> Text:
        status, text = self._shown.get(path, _UNSEEN)
        mark, style = _MARKS.get(status, _IDLE)
        line = Text("  " * depth, no_wrap=True, overflow="ellipsis")
        line.append(f"{mark} {label}", style)
        if text and status in ("RUNNING", "FAILURE"):
            line.append(f"  {text}", "italic" if status == "RUNNING" else "red")
        return line


def _leaves(outline: Outline) -> frozenset[str]:
    """Return the paths whose next row is not deeper."""
    depths = [depth for depth, _, _ in outline]
    following = [*depths[1:], 0]
    return frozenset(path for (depth, path, _), after in zip(outline, following, strict=True) if after <= depth)


def _window(statuses: list[str], room: int) -> range:
    """Return the rows to show: all, or as many as there is room for, around the last one that is running."""
    count = len(statuses)
    room = max(room, 1)
    if count <= room:
        return range(count)
    last = max((row for row, status in enumerate(statuses) if status == "RUNNING"), default=0)
    first = min(max(last - room // 2, 0), count - room)
    return range(first, first + room)
