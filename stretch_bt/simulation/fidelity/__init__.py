"""The models of the membrane, by fidelity: `hertz`, `axisymmetric` or `sheet`."""
