"""The stream of a run that is neither recorded nor watched."""

from collections.abc import Iterable

from deformpush.push_record import PushRecord


class NullStream:
    """The twin of `Stream` that keeps nothing, and needs no Rerun."""

    def catch_up(self, records: Iterable[PushRecord]) -> None:
        """Forget what was made again."""

    def push(self, record: PushRecord, picture: bytes) -> None:
        """Forget push k."""

    def close(self) -> None:
        """End nothing."""

    def release(self) -> None:
        """Let go of nothing."""
