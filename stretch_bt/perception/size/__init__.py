"""Size of a contact from one frame: shapes with the anisotropic skirt of the membrane around them, and the choice."""
