"""The objects of the twin: where their top stands, how they give way, and the part of them that the membrane meets."""
