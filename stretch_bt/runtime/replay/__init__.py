"""Replay: the same tree ticked again on the readings of a record, and the first decision that differs.

The replayed devices hand out what the record holds, tick by tick and in order; everything else, perception included, is
computed anew and written as a record of its own, whose events are compared with the recorded ones.
"""

from stretch_bt.runtime.replay.again import ReplayResult, replay

__all__ = ["ReplayResult", "replay"]
