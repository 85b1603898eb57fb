"""Balloons: the inflated skin under a hand, its fill, and how the two answer a push."""
