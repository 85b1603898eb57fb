"""Every hard case ends as it must."""

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases import DOMAINS, case, cases, registry, run


def addresses():
    for domain in DOMAINS:
        for name, hard in cases(domain).items():
            yield pytest.param(domain, name, marks=[pytest.mark.slow] * hard.costly, id=f"{domain}: {name}")


@pytest.mark.parametrize(("domain", "name"), list(addresses()))
def test_a_hard_case_ends_as_it_must(domain, name):
    row = run(domain, case(domain, name))
    assert row.ok, f"expected {row.expected}; got {row.outcome}"


@pytest.mark.parametrize("domain", DOMAINS)
def test_each_case_has_a_name_of_its_own_and_says_why_it_is_hard(domain):
    found = registry.load(domain)
    assert len({hard.name for hard in found}) == len(found) > 0
    assert all(hard.why and hard.expect.says for hard in found)


def test_an_address_that_leads_nowhere_is_told():
    with pytest.raises(InvalidInput, match=r"no domain 'fit' of hard cases; the domains are .*; did you mean 'fits'\?"):
        cases("fit")
    with pytest.raises(
        InvalidInput, match="no hard case 'none' in fits; `stretch-bt hardcases --domain fits` lists them"
    ):
        case("fits", "none")
