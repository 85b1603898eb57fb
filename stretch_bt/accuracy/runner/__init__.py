"""The time of a tick of a tree, beside bare py_trees."""
