"""Control laws of the hand: where it goes next, by what it sees and feels."""
