"""What a tick of a tree takes, beside bare py_trees."""
