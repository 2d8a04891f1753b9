"""Nothing grows with many runs: neither in the process that makes them, nor in that which looks at them.

Time is that of the processor, since others use this machine too. docs/reliability.md has the numbers.
"""

from pathlib import Path

import pytest

from benchmarks.many_runs import RUNS, VERBS, lay_out, spent
from benchmarks.resets import EARLY, ROBOTS, resets

MOST_MB = 1000
"""For looking at 10,000 runs."""
GROWTH_MB = 5
"""At most, between the fiftieth simulator and the last."""


@pytest.fixture(scope="module")
def sweep(tmp_path_factory) -> Path:
    """The folder of 10,000 finished toy runs."""
    return lay_out(tmp_path_factory.mktemp("large") / "sweep", RUNS)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize(("verb", "table"), [("status", "sweep.csv"), ("compare", "compare.csv")])
def test_a_sweep_of_ten_thousand_runs_is_looked_at_in_time(sweep, verb, table):
    _, most_s = VERBS[verb]
    took = spent([verb, str(sweep)])
    assert took.seconds < most_s
    assert took.peak_mb < MOST_MB
    assert (sweep / table).read_text().count("\n") == RUNS + 1


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("robot", ROBOTS)
def test_three_hundred_worlds_leave_nothing_behind(robot):
    left = resets([f"robot={robot}"], 300)
    assert max(now.memory for now in left[EARLY:]) - left[EARLY - 1].memory < GROWTH_MB
    assert {(now.files, now.threads) for now in left[EARLY - 1 :]} == {left[EARLY - 1][1:]}
