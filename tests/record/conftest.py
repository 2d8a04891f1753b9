"""One short made-up run, shared by the tests of this folder."""

import pytest

from deformpush.push_record import PushRecord, RunInfo
from tests.record.synthetic import SyntheticRun


@pytest.fixture(scope="session")
def run() -> tuple[RunInfo, list[PushRecord]]:
    """A run of 14 pushes (ten of them initial), without an arm."""
    made = SyntheticRun(pushes=14)
    return made.info, made.records()
