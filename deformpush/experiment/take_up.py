"""Brings an episode to where a run was: from a state that the world saved, or by making its pushes again."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from deformpush.cell.cell import Cell
from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import WorldError
from deformpush.errors import UserError
from deformpush.experiment.assemble import begin
from deformpush.experiment.recorder import Recorder, Saves
from deformpush.experiment.repeat import DivergedError, catch_up, hear, restore_optimizer
from deformpush.experiment.setup import Setup
from deformpush.loop import Episode
from deformpush.optimizer.base import Optimizer
from deformpush.push_record import PushRecord
from deformpush.record import kept
from deformpush.record.kept import Kept
from deformpush.record.table import Row
from deformpush.record.unfinished import UnfinishedRun
from deformpush.task import ERROR_COLUMNS, Errors

KEPT = "record.world_states=true keeps the states of world=mujoco and world=toy"
"""Which runs can be begun anywhere: the worlds are those that offer states."""


class NotKeptError(ValueError):
    """A run cannot be gone on from a state of it; the message is the reason, in one line."""


def saves(cell: Cell) -> Saves | None:
    """How the state of the world is saved; None where it cannot be."""
    return cell.world.save if "states" in cell.world.offers else None


def go_to(episode: Episode, past: UnfinishedRun, most: int) -> Kept:
    """Bring a fresh episode to the newest state that was saved after push `most` or before.

    What the files keep of the run until then must be what its table says, to the bit.

    Raises:
        NotKeptError: there is no such state; the episode is where it was.
    """
    try:
        if "states" not in episode.cell.world.offers:
            raise ValueError("its world saves no states")
        found = kept.read(past, most)
        _check_outlines(episode, found)
        _check(past.rows[0], episode.record.errors, 0)
        world = found.world
        episode.take_up(world.k, world.state, found.before, world.sim_time_s)
        _check(past.rows[world.k], episode.record.errors, world.k)
    except FileNotFoundError as error:
        raise NotKeptError(f"there is no {error.filename}") from error
    except OSError as error:
        raise NotKeptError(f"{error.filename} cannot be read ({error.strerror})") from error
    except (ValueError, PerceptionError) as error:
        raise NotKeptError(str(error)) from error
    return found


def go_before(episode: Episode, past: UnfinishedRun, push: int) -> Kept:
    """Bring a fresh episode to the state before a push of a run.

    Raises:
        UserError: no such state was saved, or it is not that of the run.
    """
    folder = past.folder
    try:
        found = go_to(episode, past, push - 1)
    except NotKeptError as error:
        raise UserError(f"{folder.path}: cannot begin with push {push}: {error}; {KEPT}") from error
    if found.world.k < push - 1:
        raise UserError(f"{folder.world_states}: damaged, nothing can be read after push {found.world.k}")
    return found


def take_up(
    setup: Setup,
    cell: Cell,
    optimizer: Optimizer,
    past: UnfinishedRun,
    listeners: Sequence[Callable[[PushRecord], object]],
    tell: Callable[[str], None],
) -> tuple[Episode, Recorder]:
    """Bring a run to where it ended, and let a recorder know of it.

    It goes on from the state before the newest push that the optimizer's checkpoint knows: that push and
    those after it are made again. Without such a state all are.

    Args:
        setup: the run.
        cell: freshly put up.
        optimizer: fresh.
        past: what the run left.
        listeners: hear of the pushes that are made again.
        tell: hears, in one line, why all of them are.

    Raises:
        DivergedError: the pushes do not repeat themselves.
    """
    save, knew_nothing = saves(cell), optimizer.state()
    untouched = None if save is None else save()
    episode = begin(setup, cell, optimizer)
    thought = restore_optimizer(optimizer, past)
    try:
        if past.pushes and not thought:
            raise NotKeptError(f"{past.folder.checkpoint.name} is missing or damaged")
        with _kept_if_well(Recorder(past.folder, setup.record, save)) as recorder:
            first = episode.record
            found = go_to(episode, past, max(0, thought - 1))
            recall(recorder, first, found)
            catch_up(episode, past, thought, [*listeners, recorder.remember])
        return episode, recorder
    except (NotKeptError, DivergedError, WorldError, PerceptionError) as error:
        if past.pushes:
            why = error.reason if isinstance(error, DivergedError) else error
            tell(f"{past.folder.path}: makes all {past.pushes} pushes again: {why}")
    if untouched is not None:
        cell.world.restore(untouched)
    optimizer.restore(knew_nothing)
    episode = begin(setup, cell, optimizer)
    with _kept_if_well(Recorder(past.folder, setup.record, save)) as recorder:
        every = [*listeners, recorder.remember]
        hear(past, episode.record, every)
        catch_up(episode, past, restore_optimizer(optimizer, past), every)
    return episode, recorder


def recall(recorder: Recorder, first: PushRecord, found: Kept) -> None:
    """Let a recorder know of the pushes that need not be made again; `first` is row 0."""
    recorder.recall(first, found.state(0))
    for k in range(1, found.world.k + 1):
        recorder.recall(found.record(k), found.state(k))


@contextmanager
def _kept_if_well(recorder: Recorder) -> Iterator[Recorder]:
    """Let a recorder go if something goes wrong before it is opened."""
    try:
        yield recorder
    except BaseException:
        recorder.release()
        raise


def _check_outlines(episode: Episode, found: Kept) -> None:
    """Hold the outlines that are kept against the table.

    Raises:
        ValueError: one is not that of its row.
    """
    perception = episode.cell.perception
    for k in range(found.world.k + 1):
        seen = found.seen(k)
        seen = replace(seen, gamma=perception.shape(seen.contour, seen.c, seen.theta))
        _check(found.run.rows[k], episode.task.errors(seen, episode.target), k)


def _check(row: Row, errors: Errors, k: int) -> None:
    """Hold errors against a row, bit for bit.

    Raises:
        ValueError: they differ.
    """
    for column in ERROR_COLUMNS:
        if not np.array_equal(row[column], errors[column]):
            raise ValueError(f"what is kept of push {k} is not what its row says ({column})")
