"""Devices behind one interface each: the cell, its watch over limits and faults, and what stands behind a device."""
