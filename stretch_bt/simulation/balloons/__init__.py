"""Balloons: the inflated skin under a hand, what fills it, and how the two answer a push."""
