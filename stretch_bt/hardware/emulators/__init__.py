"""Stand-ins for field devices: they speak the device's protocol to the same clients that a robot would be reached by.

A stand-in shows that client, wire and driver work together; of the device itself it knows only what its manual says.
"""
