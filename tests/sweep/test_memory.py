"""What an item has used is given back after it."""

import weakref

from stretch_bt.sweep.memory import give_back


class World:
    """One that holds itself."""

    def __init__(self):
        self.itself = self


def test_what_holds_itself_is_gone():
    gone = weakref.ref(World())
    assert gone() is not None
    give_back()
    assert gone() is None
