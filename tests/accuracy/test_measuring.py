"""Which jobs are measured, and in which part of several."""

import pytest

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.measuring import _part
from stretch_bt.accuracy.points import Setting


@pytest.mark.parametrize("seconds", [[1.0, 2.0, 0.0], [0.0], [0.0, 0.0], [3.0, 1.0, 1.0, 0.0, 0.0]])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_every_job_is_in_one_part(seconds, count):
    """The last one was in none where it takes no time."""
    jobs = [Job("a", Setting("s", "v"), "error", each, list) for each in seconds]
    parts = [_part(jobs, number, count) for number in range(1, count + 1)]
    assert [job for part in parts for job in part] == jobs
