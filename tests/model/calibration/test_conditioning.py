import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.model.calibration.characterization import Press, as_table
from stretch_bt.model.calibration.conditioning import CONDITIONED, Conditioning
from stretch_bt.model.calibration.measurements import Measurements


@pytest.mark.parametrize("made", [Conditioning(), Conditioning(0.08, 0.015), Conditioning(0.0, 0.01)])
def test_a_table_says_it_again(made):
    assert Conditioning.of({CONDITIONED: made.to_json()}) == made


def test_it_is_said_in_words():
    assert str(Conditioning()) == "not conditioned"
    assert str(Conditioning(0.08, 0.015)) == "conditioned to a stretch of 80 mm and a depth of 15 mm"


@pytest.mark.parametrize(
    "wrong", [True, 0.08, {}, {"stretch": 0.08}, {"stretch": "80 mm", "depth": 0.01}, {"stretch": -1, "depth": 0.01}]
)
def test_what_is_no_stretch_and_depth_is_refused(wrong):
    with pytest.raises(InvalidInput, match="conditioned: a table says"):
        Conditioning.of({CONDITIONED: wrong})


@pytest.mark.parametrize("said", [None, Conditioning(), Conditioning(0.08, 0.015)])
def test_measurements_know_it_from_their_table(said):
    row = Press("sphere", 0.02, 0.01, 0.005, 1, 0.4, 0.01, 0.05, 0.0)
    table = as_table({} if said is None else {CONDITIONED: said.to_json()}, [row, row])
    given = Measurements.of(table)
    assert given.conditioned == said
    assert given.where(given.depth > 0).conditioned == said
