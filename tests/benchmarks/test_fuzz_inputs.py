"""The fuzz of own nodes and mocks files, short."""

from fuzz_inputs import main


def test_no_case_ends_otherwise_than_it_should(own_nodes):
    assert main(25, 1) == 0
