"""Long runs of one thing each, and what must not change in their course."""
