"""A controller of Universal Robots that is not there."""
