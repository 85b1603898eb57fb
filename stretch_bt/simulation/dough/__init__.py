"""A lump of dough that is rolled and pressed: its radius in every direction, and what a force makes of it."""
