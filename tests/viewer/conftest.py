"""The made-up run of the tests of recording."""

from tests.record.conftest import run

__all__ = ["run"]
