"""The worth of each effect of the twin in its scenes, and its cost."""
