"""Force laws of the hand behind one interface."""
