"""What the domains' tests share."""

from dataclasses import replace

import pytest

from stretch_bt.accuracy import measure


@pytest.fixture(scope="session")
def measured():
    """A function that measures the given jobs of a domain, each once, however fast the machine is."""

    def rows(name, domain, jobs):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(
                "stretch_bt.accuracy.measuring.domains", lambda names: {name: replace(domain, jobs=lambda quick: jobs)}
            )
            patch.setattr("stretch_bt.accuracy.measuring.TIMES", 1)
            return list(measure([name]))

    return rows
