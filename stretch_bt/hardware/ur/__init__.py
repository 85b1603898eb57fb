"""Robot arms of Universal Robots."""
