"""From a table of measured presses to a force law, and the tables of the trees that measure."""
