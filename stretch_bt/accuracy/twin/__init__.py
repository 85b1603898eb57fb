"""What each effect of the twin is worth in its scenes, and what it costs."""
