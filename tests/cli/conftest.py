"""The made-up sweep of the tests of studies."""

from tests.study.conftest import sweep

__all__ = ["sweep"]
