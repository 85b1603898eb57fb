"""Arguments of Python calls that are of another kind than asked are refused by their names."""

import pytest

import stretch_bt
from stretch_bt.errors import InvalidInput

#: of `run`, one at a time
WRONG = {
    "tree": (None, 3, b"x"),
    "scene": (3,),
    "cell": (3, object()),
    "params": (3, ["depth"]),
    "mocks": (3, []),
    "out": (3,),
    "devices": (3, []),
    "modules": (3,),
    "record": (None, 3),
    "tolerance": (3, "2 %"),
}


@pytest.mark.parametrize(("name", "given"), [(name, given) for name, wrong in WRONG.items() for given in wrong])
def test_a_run_names_what_is_of_another_kind(name, given):
    with pytest.raises(InvalidInput, match=f"^{name} takes "):
        stretch_bt.run(**{"tree": "watch_contact", name: given})


@pytest.mark.parametrize(
    "call",
    [
        lambda: stretch_bt.open_cell(3),
        lambda: stretch_bt.open_cell(scene=3),
        lambda: stretch_bt.subtree(None, None),
        lambda: stretch_bt.check(None),
        lambda: stretch_bt.check([3]),
    ],
)
def test_so_does_each_other_call(call):
    with pytest.raises(InvalidInput, match=" takes the path"):
        call()


def test_an_open_cell_has_its_seed():
    with stretch_bt.open_cell(scene="water_balloon", seed=3) as cell, pytest.raises(InvalidInput, match="seed, 3"):
        stretch_bt.run("watch_contact", cell=cell, seed=4)
