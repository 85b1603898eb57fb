"""The force model that solves the sheet says what its table says, but for the table's own error."""

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model import ForceModel
from stretch_bt.model.force.force_model import shipped
from stretch_bt.simulation.sheet_model import SheetModel

TABLE, SHEET = shipped("membrane"), shipped("sheet")
PLACES = [(r, x, d) for r in (0.008, 0.02, 0.03) for x in (0.0, 0.04, 0.08) for d in (0.0005, 0.003, 0.012)]


def test_it_agrees_with_the_table():
    ratios = np.array([SHEET.predict(*place)[0] / TABLE.predict(*place)[0] for place in PLACES])
    assert np.abs(ratios - 1).max() < 0.03
    assert np.sqrt(np.mean((ratios - 1) ** 2)) < 0.012
    for place in PLACES:
        force, sd = SHEET.predict(*place)
        assert sd / force == pytest.approx(TABLE.predict(*place)[1] / TABLE.predict(*place)[0])


@pytest.mark.parametrize("place", [(0.01, 0.02, 0.006), (0.03, 0.06, 0.011), (0.02, 0.0, 0.004), (0.01, 0.08, 0.015)])
def test_its_inverses_reach_the_force(place):
    radius, stretch, depth = place
    force, _ = SHEET.predict(*place)
    assert SHEET.depth_for(radius, stretch, force) == pytest.approx(depth, rel=2e-3)
    assert SHEET.stretch_for(radius, depth, force) == pytest.approx(stretch, rel=2e-2, abs=1e-4)


def test_a_force_does_not_hang_on_what_was_asked_before():
    place = (0.03, 0.0, 0.0015)
    found = []
    for before in ((0.03, 0.0, 0.0022), (0.01, 0.06, 0.012), (0.03, 0.02, 0.0005)):
        SHEET.predict(*before)
        found.append(SHEET.predict(*place)[0])
    assert found == pytest.approx([found[0]] * 3, rel=1e-3)

    depths = []
    for before in ((0.03, 0.0, 0.0022), (0.01, 0.06, 0.012)):
        SHEET.predict(*before)
        depths.append(SHEET.depth_for(0.02, 0.03, 0.8))
    assert depths == pytest.approx([depths[0]] * 2, rel=1e-3)


def test_friction_and_softening_are_those_of_the_table():
    hand = TABLE.hand._replace(friction=1.0, softening=0.1)
    made = [cls(hand, TABLE.covariance, 0.01, TABLE.range) for cls in (SheetModel, type(TABLE))]
    bare = [m.predict(0.02, 0.06, 0.012)[0] for m in (SHEET, TABLE)]
    changed = [m.predict(0.02, 0.06, 0.012)[0] for m in made]
    assert changed[0] / bare[0] == pytest.approx(changed[1] / bare[1], rel=5e-3)


def test_it_refuses_as_the_table_does(tmp_path):
    with pytest.raises(InvalidInput, match="stretch"):
        SHEET.predict(0.01, 0.2, 0.01)
    with pytest.raises(NoEquilibrium):
        SHEET.depth_for(0.01, 0.0, 100.0)
    assert SHEET.predict(0.01, 0.02, 0.0) == (0.0, 0.0)
    assert SHEET.depth_for(0.01, 0.02, 0.0) == 0.0
    SHEET.save(tmp_path / "hand.json")
    assert ForceModel.load(tmp_path / "hand.json").kind == "sheet"


def test_it_keeps_no_more_of_stretches_than_it_may():
    model = SheetModel(TABLE.hand, TABLE.covariance, 0.01, TABLE.range)
    for stretch in np.linspace(0.02, 0.03, 30).tolist():
        model.predict(0.01, stretch, 0.005)
    assert len(model._hangs) <= 24
