"""The depth camera of the twin: its view of the membrane, and its errors."""
