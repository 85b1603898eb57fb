"""Tolerances that a run asks for, as they are written."""

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.scene.asked import asked_pairs, read_asked


@pytest.mark.parametrize(
    ("texts", "found"),
    [
        (["stiffness=2%"], {"stiffness": 0.02}),
        (["height = 0.3 mm", "force=1 %"], {"height": 3e-4, "force": 0.01}),
        (["size=50um", "roundness=0.5%"], {"size": 5e-5, "roundness": 0.005}),
    ],
)
def test_texts_of_a_command_line(texts, found):
    assert read_asked(asked_pairs(texts)).named() == pytest.approx(found)


def test_si_numbers_of_python():
    assert read_asked({"height": 3e-4, "force": 0.02}).named() == {"height": 3e-4, "force": 0.02}


@pytest.mark.parametrize(
    ("texts", "says"),
    [
        (["stiffness"], "takes NAME=P, not 'stiffness'; write --tolerance stiffness=2%"),
        (["=2%"], "takes NAME=P"),
        (["force="], "takes NAME=P"),
        (["force=1%", "force=2%"], "force is given twice"),
        (["stifness=2%"], "there is no result 'stifness'; did you mean 'stiffness'?"),
        (["height=3%"], "height takes a length, not '3%'; write --tolerance height=0.3mm"),
        (["size=0.3"], "size takes a length"),
        (["force=2mm"], "force takes a percentage, not '2mm'; write --tolerance force=2%"),
        (["force=0.02"], "force takes a percentage"),
        (["roundness=abc"], "roundness takes a percentage"),
        (["force=0%"], "force: 0 % is out of bounds; write at least 0.0001 %"),
        (["height=1m"], "height: 1000 mm is out of bounds"),
    ],
)
def test_mistakes(texts, says):
    with pytest.raises(InvalidInput) as refused:
        read_asked(asked_pairs(texts))
    assert says in str(refused.value)


@pytest.mark.parametrize("given", [{}, {"force": None}, {"force": True}, {"force": float("nan")}, {"force": [0.02]}])
def test_what_is_no_tolerance(given):
    with pytest.raises(InvalidInput, match="--tolerance"):
        read_asked(given)
