"""Every hard case ends as it must."""

import pytest

from stretch_bt.hardcases import DOMAINS, case, cases, run


def addresses():
    for domain in DOMAINS:
        for name, hard in cases(domain).items():
            yield pytest.param(domain, name, marks=[pytest.mark.slow] * hard.costly, id=f"{domain}: {name}")


@pytest.mark.parametrize(("domain", "name"), list(addresses()))
def test_a_hard_case_ends_as_it_must(domain, name):
    row = run(domain, case(domain, name))
    assert row.ok, f"expected {row.expected}; got {row.outcome}"
