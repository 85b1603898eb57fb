"""Protocols of palpation on the balloons of the twin: how far off their stiffness is, and the robot's time that it takes."""
