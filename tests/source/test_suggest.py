"""Suggestions take no time that grows with what a file holds."""

import random

from stretch_bt.source import closest


def test_long_words_are_compared_with_nothing() -> None:
    random.seed(0)
    long = ["".join(chr(random.randrange(0x4E00, 0x9000)) for _ in range(50_000)) for _ in range(20)]
    assert closest(long[0], long) is None  # comparing them takes minutes
    assert closest("depht", [*long, "depth"]) == "depth"
