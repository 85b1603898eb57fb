"""The record of a run: a folder that says what was run, what happened, what the devices read, and how it ended.

| file | holds |
|---|---|
| run.json | command line, paths, versions, wall time: what differs between two identical runs |
| events.jsonl | status changes, key writes, commands, motions, faults: identical for identical runs |
| record.mcap | frames, points and readings in the schemas that Foxglove and Rerun open; what replay needs |
| result.json | status, reason, outputs |
| report.html | the page for people |
"""

from stretch_bt.runtime.record.reader import Handed, RecordReader
from stretch_bt.runtime.record.recorder import RunRecord

__all__ = ["Handed", "RecordReader", "RunRecord"]
