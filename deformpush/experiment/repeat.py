"""Makes the pushes of an earlier run again, and notices where the world or the optimizer does otherwise."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from deformpush.errors import TroubleError
from deformpush.loop import Episode
from deformpush.push_record import PushRecord
from deformpush.record.unfinished import Difference, UnfinishedRun, differences


class DivergedError(TroubleError):
    """A push made again ended elsewhere, or the optimizer now wants another."""


def catch_up(
    episode: Episode, past: UnfinishedRun, listeners: Sequence[Callable[[PushRecord], object]] = ()
) -> None:
    """Bring a fresh episode to where an unfinished run ends, for the price of its pushes.

    The optimizer takes its state from the checkpoint and thinks again only about the pushes after it. Every
    state must be, to the bit, the one that was recorded. Listeners hear of each, row 0 first; its decision is
    as far as pushes.csv tells it.

    Raises:
        DivergedError: it is not the same run any more.
    """
    start = 0
    if (saved := past.checkpoint) is not None:
        fresh = episode.optimizer.state()
        try:
            episode.optimizer.restore(saved.state)
            start = saved.k
        except (KeyError, ValueError, TypeError):  # of another version: what it knew is worked out anew
            episode.optimizer.restore(fresh)
    _heard(past, episode.record, listeners)
    for k in range(1, past.pushes + 1):
        made = past.proposal(k)
        if k <= start:
            record = episode.repeat(made)
        else:
            record = episode.push(u=made.u, speed=made.speed)
            if episode.wanted is None or not np.array_equal(episode.wanted, made.u):
                raise DivergedError(
                    f"{_at(past, k)}: the optimizer {wants(episode)}, it pushed {_text(made.u)}"
                )
        _heard(past, record, listeners)


def replay(
    episode: Episode, past: UnfinishedRun, maps: bool = False
) -> Iterator[tuple[PushRecord, list[Difference]]]:
    """Make the recorded pushes again, asking the optimizer too; yield each state and what is different in it.

    Row 0 comes first. It goes on after a difference, with the pushes as they were recorded.
    """
    yield episode.record, differences(past.rows[0], episode.record)
    for k in range(1, past.pushes + 1):
        made = past.proposal(k)
        record = episode.push(maps, made.u, made.speed)
        yield record, differences(past.rows[k], record)


def wants(episode: Episode) -> str:
    """What the optimizer chose, in words."""
    assert episode.wanted is not None
    return f"now chooses {_text(episode.wanted)}"


def _heard(
    past: UnfinishedRun, record: PushRecord, listeners: Sequence[Callable[[PushRecord], object]]
) -> None:
    """Let listeners hear of a state that is as it was."""
    if others := differences(past.rows[record.k], record):
        raise DivergedError(f"{_at(past, record.k)}: {others[0]}; made with another version or machine?")
    for listener in listeners:
        listener(record)


def _at(past: UnfinishedRun, k: int) -> str:
    return f"{past.folder.path}: cannot be continued exactly, push {k} does not repeat itself"


def _text(u: np.ndarray) -> str:
    return f"kappa = {u[0]:.6g}, d = {u[1] * 1e3:.6g} mm"
