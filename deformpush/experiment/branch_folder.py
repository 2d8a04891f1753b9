"""Writes a branch as a run folder of its own: the run up to push k - 1, then the other push k."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

from deformpush.experiment.assemble import describe
from deformpush.experiment.branch import Branch
from deformpush.experiment.recorder import Recorder
from deformpush.experiment.take_up import recall, saves
from deformpush.push_record import Ending, PushRecord
from deformpush.record import world_states
from deformpush.record.files import TABLE_BYTES, read_bytes
from deformpush.record.folder import FORECASTS, RunFolder
from deformpush.record.unfinished import UnfinishedRun
from deformpush.study import run_figure


def write(branch: Branch, record: PushRecord, into: str | Path) -> RunFolder:
    """Write the push that the branch has just made, behind those before it.

    The recording shows the states before, and the push itself with all that happened in it. There is no
    checkpoint: no optimizer chose this push.

    Raises:
        FolderError: the folder holds results, or cannot be written.
    """
    setup, run = branch.setup, branch.run
    folder = RunFolder.create(into, setup.yaml)
    recorder = Recorder(folder, setup.record, saves(branch.episode.cell))
    with recorder:
        lock = folder.claim()
        try:
            _copy_until(run.folder, folder, branch.before.k)
        except BaseException:
            lock.release()
            raise
        recall(recorder, branch.first, branch.kept)
        past = UnfinishedRun(folder, run.rows[: record.k], None)
        world = branch.episode.cell.world
        after = world.save()
        recorder.reopen(describe(setup, branch.episode), past, None, lock, _states(branch))
        world.restore(after)
        recorder(record)
        ending = Ending.of(record, setup.task, setup.max_pushes)
        status = "budget" if ending is None else ending.status
        recorder.close(status, f"what if push {record.k} of {run.folder.path} had been another")
    if setup.record.figures:
        run_figure.draw(folder)
    return folder


def _states(branch: Branch) -> Iterator[tuple[PushRecord, bytes]]:
    """The pushes before with what is seen of each in the world, which is taken to one after the other."""
    episode, kept = branch.episode, branch.kept
    for world in islice(world_states.states(branch.run.folder.world_states, branch.before.k), 1, None):
        episode.take_up(world.k, world.state, kept.seen(world.k - 1), world.sim_time_s)
        now = episode.record
        yield replace(kept.record(world.k), view=now.view, timing=now.timing), kept.pictures[world.k]


def _copy_until(run: RunFolder, folder: RunFolder, k: int) -> None:
    """Copy what grows push by push, up to push k."""
    rows = read_bytes(run.table, TABLE_BYTES).splitlines(keepends=True)
    folder.write(folder.table.name, b"".join(rows[: k + 2]))
    forecasts = run.path / FORECASTS
    if forecasts.exists():
        folder.write(FORECASTS, read_bytes(forecasts, TABLE_BYTES))
    world_states.copy(run.world_states, folder.world_states, k)
