"""What stands in for the membrane, by fidelity: `hertz`, `axisymmetric` or `sheet`."""
