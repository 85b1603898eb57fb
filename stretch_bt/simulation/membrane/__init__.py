"""The membrane of the twin, one module a fidelity."""
