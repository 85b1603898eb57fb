"""What tests of palpation share."""

import pytest

from stretch_bt.runtime.onlooker import Onlooker


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
