"""Long runs of one thing each, and quantities that must not change in their course."""
