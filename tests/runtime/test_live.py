import io
from typing import Any

import pytest
from rich.console import Console

from stretch_bt.runtime.live import LiveView

OUTLINE = [(0, "main", "main"), (1, "main/a", "set_stretch"), (1, "main/b", "until"), (2, "main/b/c", "press")]


def view(**options: Any) -> tuple[LiveView, io.StringIO]:
    stream = io.StringIO()
    return LiveView(Console(file=stream, width=80, **options)), stream


def test_without_a_terminal_each_change_of_an_action_is_a_line() -> None:
    live, stream = view()
    live.start(OUTLINE)
    live.update(0.0, {"main": ("RUNNING", ""), "main/a": ("RUNNING", "1 mm [left]"), "main/b/c": ("INVALID", "")})
    live.update(0.5, {"main": ("RUNNING", "x"), "main/a": ("RUNNING", "0 mm left")})
    live.update(1.0, {"main/a": ("SUCCESS", ""), "main/b/c": ("RUNNING", "deeper")})
    live.update(1.5, {"main/b/c": ("INVALID", "")})
    live.stop()
    assert stream.getvalue().splitlines() == [
        "     0.00 s  running     main/a  1 mm [left]",
        "     1.00 s  success     main/a",
        "     1.00 s  running     main/b/c  deeper",
        "     1.50 s  interrupted main/b/c",
    ]


def test_a_terminal_keeps_the_last_picture_of_the_whole_tree() -> None:
    live, stream = view(force_terminal=True, color_system=None, height=10, _environ={})
    live.start(OUTLINE)
    live.update(
        2.5, {"main/a": ("SUCCESS", "done"), "main/b": ("RUNNING", "3 of 120"), "main/b/c": ("FAILURE", "too deep")}
    )
    live.stop()
    live.stop()
    picture = [line.rstrip() for line in stream.getvalue().splitlines()[-4:]]
    assert picture[0].endswith("· main")
    assert picture[1:] == ["  ✓ set_stretch", "  ▶ until  3 of 120", "    ✗ press  too deep"]
    assert "task time 2.5 s" in stream.getvalue()


@pytest.mark.parametrize("running", [0, 7, 60, 99])
def test_a_tall_tree_is_cut_to_what_runs(running: int) -> None:
    live, stream = view(force_terminal=True, color_system=None, height=12, _environ={})
    live.start([(0, f"n{row}", f"node{row:02d}") for row in range(100)])
    live.update(0.0, {f"n{running}": ("RUNNING", "")})
    assert live._live is not None
    live._live.refresh()
    drawn = stream.getvalue().rpartition("task time")[2].splitlines()
    live.stop()
    assert len(drawn) == 11
    assert any(line.startswith(f"▶ node{running:02d}") for line in drawn)


def test_by_default_it_writes_to_standard_error(capsys: pytest.CaptureFixture[str]) -> None:
    live = LiveView()
    live.start([(0, "main", "main")])
    live.update(0.0, {"main": ("RUNNING", "")})
    live.stop()
    captured = capsys.readouterr()
    assert (captured.out, "running" in captured.err) == ("", True)
