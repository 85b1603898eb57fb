"""A lump of dough that is rolled and pressed: its radius in every direction, and how a force changes it."""
