"""Where a hand goes: paths through poses, and how far along them it is at each time; for drivers, simulated devices and stand-ins."""
