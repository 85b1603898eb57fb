"""What a scene simulates, and what it looks like."""
