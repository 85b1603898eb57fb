"""YAML text to a checked task to py_trees nodes."""
