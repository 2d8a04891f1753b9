"""Makes the pushes of an earlier run again, and notices where the world or the optimizer does otherwise."""

from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace

import numpy as np

from deformpush.errors import TroubleError
from deformpush.loop import Episode
from deformpush.push_record import PushRecord
from deformpush.record.unfinished import Past, difference


class DivergedError(TroubleError):
    """A push made again ended elsewhere, or the optimizer now wants another."""


def catch_up(
    episode: Episode, past: Past, watch: Callable[[PushRecord], None] = lambda record: None
) -> list[PushRecord]:
    """Bring a fresh episode to where the past ends, for the price of its pushes.

    The optimizer takes its state from the checkpoint and thinks again only about the pushes after it. Every
    state must be, to the bit, the one that was recorded.

    Returns:
        The states, row 0 first. Decisions are as far as pushes.csv tells them.

    Raises:
        DivergedError: it is not the same run any more.
    """
    start = 0
    if (saved := past.checkpoint) is not None:
        fresh = deepcopy(episode.cell.optimizer)
        try:
            episode.cell.optimizer.restore(saved.state)
            start = saved.k
        except (KeyError, ValueError, TypeError):  # of another version: what it knew is worked out anew
            episode.cell = replace(episode.cell, optimizer=fresh)
    records = [episode.first]
    _same(past, records[0])
    watch(records[0])
    for k in range(1, past.pushes + 1):
        decision = past.decision(k)
        if k <= start:
            record = episode.again(decision)
        else:
            u = np.array([decision.kappa, decision.d])
            record = episode.push(u=u, speed=decision.speed)
            if episode.wanted is None or not np.array_equal(episode.wanted, u):
                raise DivergedError(f"{_at(past, k)}: the optimizer {wants(episode)}, it pushed {_text(u)}")
        _same(past, record)
        records.append(record)
        watch(record)
    return records


def replay(episode: Episode, past: Past, maps: bool = False) -> Iterator[tuple[PushRecord, str | None]]:
    """Make the recorded pushes again, asking the optimizer too; yield each state and what is different in it.

    Row 0 comes first. It goes on after a difference, with the pushes as they were recorded.
    """
    yield episode.first, difference(past.rows[0], episode.first)
    for k in range(1, past.pushes + 1):
        decision = past.decision(k)
        record = episode.push(maps, np.array([decision.kappa, decision.d]), decision.speed)
        yield record, difference(past.rows[k], record)


def wants(episode: Episode) -> str:
    """What the optimizer chose, in words."""
    assert episode.wanted is not None
    return f"now chooses {_text(episode.wanted)}"


def _same(past: Past, record: PushRecord) -> None:
    if (other := difference(past.rows[record.k], record)) is not None:
        raise DivergedError(f"{_at(past, record.k)}: {other}; made with another version or machine?")


def _at(past: Past, k: int) -> str:
    return f"{past.folder.path}: cannot be continued exactly, push {k} does not repeat itself"


def _text(u: np.ndarray) -> str:
    return f"kappa = {u[0]:.6g}, d = {u[1] * 1e3:.6g} mm"
