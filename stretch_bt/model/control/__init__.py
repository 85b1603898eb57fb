"""Control laws of the hand: where it goes next, from its readings."""
