"""The membrane of the twin, one module a solver: `hertz`, `axisymmetric` and `sheet`."""
