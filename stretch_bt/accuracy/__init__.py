"""Errors of answers, and their costs: work-precision points, one domain a file.

A domain is a module `domain_NAME` of this package with a `DOMAIN`, which says which errors are measured and how they are shown.
"""

from stretch_bt.accuracy.job import Domain, Job
from stretch_bt.accuracy.measuring import measure
from stretch_bt.accuracy.points import Answer, Kind, Row, Setting
from stretch_bt.accuracy.registry import domains

__all__ = ["Answer", "Domain", "Job", "Kind", "Row", "Setting", "domains", "measure"]
