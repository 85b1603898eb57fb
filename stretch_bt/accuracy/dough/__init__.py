"""Rolling dough: how far the reduced body is off one with many more directions, and off another program."""
