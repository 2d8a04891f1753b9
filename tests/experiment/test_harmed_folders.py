"""A run folder that a stranger harmed: every verb reads it or says why not, and touches nothing else."""

import random

import pytest

from tests.fuzz_folders import make_sweep, tried


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    return make_sweep(tmp_path_factory.mktemp("harmed") / "sweep")


@pytest.mark.parametrize("first", range(0, 12, 4))
def test_a_harmed_folder_is_read_or_refused(first, sweep):
    for number in range(first, first + 4):
        done, became, said = tried(sweep, random.Random(number))
        assert became != "wrong", f"{done}: {said}"


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1000, 1400, 20))
def test_many_harmed_folders_are_read_or_refused(first, sweep):
    for number in range(first, first + 20):
        done, became, said = tried(sweep, random.Random(number))
        assert became != "wrong", f"{done}: {said}"
