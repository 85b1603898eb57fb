"""Robotiq 2F-85 and 2F-140 grippers: by Modbus, and by the socket of Robotiq's URCap."""
