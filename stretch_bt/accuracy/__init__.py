"""How far off an answer is, and what it costs: work-precision points, one domain a file.

A domain is a module `domain_NAME` of this package with a `DOMAIN`, which says what is measured and how it is shown.
"""

from stretch_bt.accuracy.job import Domain, Job
from stretch_bt.accuracy.measuring import measure
from stretch_bt.accuracy.points import Answer, Kind, Row, Setting
from stretch_bt.accuracy.registry import domains

__all__ = ["Answer", "Domain", "Job", "Kind", "Row", "Setting", "domains", "measure"]
