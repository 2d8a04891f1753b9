"""One made-up sweep, shared by the tests of this folder."""

from pathlib import Path

import pytest

from tests.record.conftest import run
from tests.study.folders import finished

__all__ = ["run", "sweep"]


@pytest.fixture(scope="session")
def sweep(tmp_path_factory) -> Path:
    """Two weights with two seeds each, of different lengths; one run of them did not reach the goal."""
    folder = tmp_path_factory.mktemp("runs") / "sweep"
    finished(folder / "acq.w=1,seed=0", 12, seed=0, w=1.0)
    finished(folder / "acq.w=1,seed=1", 15, seed=1, w=1.0, status="budget")
    finished(folder / "acq.w=2,seed=0", 4, seed=0, w=2.0)
    finished(folder / "acq.w=2,seed=1", 11, seed=1, w=2.0)
    return folder
