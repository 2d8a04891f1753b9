"""The made-up runs of these tests and their recordings."""

import pytest

from tests.record.conftest import run
from tests.record.synthetic import SyntheticRun, kuka
from tests.viewer.recording import Recorded

__all__ = ["run"]


@pytest.fixture(scope="session")
def full(tmp_path_factory) -> Recorded:
    """Twelve pushes (ten of them initial) with an arm, a mesh, maps, forecasts, force and limits."""
    made = SyntheticRun(12, urdf=kuka(), forecasts=True, force=True)
    return Recorded.make(tmp_path_factory.mktemp("run") / "full", made)


@pytest.fixture(scope="session")
def plain(tmp_path_factory) -> Recorded:
    """Two pushes with a bare tool, without mesh, strain, maps or forecasts."""
    return Recorded.make(tmp_path_factory.mktemp("run") / "plain", SyntheticRun(2, mesh=False), maps=False)
