"""The simulated cell: devices that take time on the injected clock and act on one simulated world."""
