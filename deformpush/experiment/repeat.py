"""Makes the pushes of an earlier run again, and notices where the world or the optimizer does otherwise."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from deformpush.errors import TroubleError
from deformpush.loop import Episode
from deformpush.optimizer.base import Optimizer
from deformpush.push_record import PushRecord
from deformpush.record.unfinished import Difference, UnfinishedRun, differences


class DivergedError(TroubleError):
    """A push made again ended elsewhere, or the optimizer now wants another."""

    def __init__(self, past: UnfinishedRun, k: int, why: str) -> None:
        self.reason = f"push {k} does not repeat itself: {why}"
        super().__init__(f"{past.folder.path}: cannot be continued exactly, {self.reason}")


def restore_optimizer(optimizer: Optimizer, past: UnfinishedRun) -> int:
    """Give a fresh optimizer the state of the run's checkpoint; the push that it follows, 0 without one."""
    if (saved := past.checkpoint) is None:
        return 0
    fresh = optimizer.state()
    try:
        optimizer.restore(saved.state)
    except (KeyError, ValueError, TypeError):  # of another version: what it knew is worked out anew
        optimizer.restore(fresh)
        return 0
    return saved.k


def catch_up(
    episode: Episode,
    past: UnfinishedRun,
    thought: int,
    listeners: Sequence[Callable[[PushRecord], object]] = (),
) -> None:
    """Bring an episode to where an unfinished run ends, for the price of the pushes from where it is.

    The optimizer thinks again only about the pushes after push `thought`. Every state must be, to the bit,
    the one that was recorded. Listeners hear of each push that is made; its decision is as far as pushes.csv
    tells it.

    Raises:
        DivergedError: it is not the same run any more.
    """
    for k in range(episode.record.k + 1, past.pushes + 1):
        made = past.proposal(k)
        if k <= thought:
            record = episode.repeat(made)
        else:
            record = episode.push(u=made.u, speed=made.speed)
            if episode.wanted is None or not np.array_equal(episode.wanted, made.u):
                raise DivergedError(past, k, f"the optimizer {wants(episode)}, it pushed {in_words(made.u)}")
        hear(past, record, listeners)


def replay(
    episode: Episode, past: UnfinishedRun, maps: bool = False
) -> Iterator[tuple[PushRecord, list[Difference]]]:
    """Make the recorded pushes again, yield each state and what is different in it.

    It goes on after a difference, with the pushes as they were recorded. An episode that begins with row 0
    yields that first, and asks the optimizer too; what that knew at a later beginning, nobody kept.
    """
    if (begins := episode.record.k) == 0:
        yield episode.record, differences(past.rows[0], episode.record)
    for k in range(begins + 1, past.pushes + 1):
        made = past.proposal(k)
        record = episode.repeat(made) if begins else episode.push(maps, made.u, made.speed)
        yield record, differences(past.rows[k], record)


def wants(episode: Episode) -> str:
    """What the optimizer chose, in words."""
    assert episode.wanted is not None
    return f"now chooses {in_words(episode.wanted)}"


def hear(
    past: UnfinishedRun, record: PushRecord, listeners: Sequence[Callable[[PushRecord], object]] = ()
) -> None:
    """Let listeners hear of a state that is as it was.

    Raises:
        DivergedError: it is not.
    """
    if others := differences(past.rows[record.k], record):
        raise DivergedError(past, record.k, f"{others[0]}; made with another version or machine?")
    for listener in listeners:
        listener(record)


def in_words(u: np.ndarray) -> str:
    """A push (kappa, d), d in metres."""
    return f"kappa = {u[0]:.6g}, d = {u[1] * 1e3:.6g} mm"
