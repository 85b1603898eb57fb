"""How far off an answer is, and what it costs: work-precision points, one domain a file.

A domain is a module `domain_NAME` of this package with `ABOUT`, a text that says what its errors are measured against,
`KINDS`, how each kind of error is shown, and `points(quick)`, which yields a Point for each figure.
"""

from stretch_bt.accuracy.points import Kind, Point, Row
from stretch_bt.accuracy.registry import domains, measure

__all__ = ["Kind", "Point", "Row", "domains", "measure"]
