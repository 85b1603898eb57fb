"""The digital twin: what a scene holds, how membrane and object meet, and what the camera sees of it."""
