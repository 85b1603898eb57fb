"""The depth camera of the twin: what it sees of the membrane, and what it adds to it."""
