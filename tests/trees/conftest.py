"""What tests of palpation share."""

from importlib.resources import files

import pytest

from stretch_bt.runtime.onlooker import Onlooker


@pytest.fixture
def hand_at(tmp_path):
    """Return a function that writes the simulated cell with the hand at a height, mm, so near to an object, and a prompt operator."""

    def write(height):
        text = (files("stretch_bt") / "trees" / "cells" / "simulated.yaml").read_text("utf-8")
        for shipped, ours in (
            ("height: 120 mm}", f"height: {height} mm}}"),
            ("type: Operator, use: simulated}", "type: Operator, use: simulated, delay: 3 s}"),
        ):
            assert shipped in text
            text = text.replace(shipped, ours)
        path = tmp_path / "cell.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def pressed():
    """Return the scene's own force at each press, N, of the run so far, and the function that watches a run for it."""
    forces = []

    def watch(runner):
        class Ends(Onlooker):
            def write(self, key, value, sd, path):
                if key.endswith("/pressed_at"):
                    forces.append(runner.cell.truth()["force"])

        runner.watchers.append(Ends())

    return forces, watch
