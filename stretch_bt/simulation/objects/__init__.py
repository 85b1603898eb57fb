"""The objects of the twin: where their top stands, how they give way, and what the membrane meets of them."""
