"""Walks through a run again and tries other pushes from each of its states: regret and calibration."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import WorldError
from deformpush.errors import UserError
from deformpush.experiment.assemble import begin
from deformpush.experiment.branch import PHASE
from deformpush.experiment.one_thread import one_thread
from deformpush.experiment.repeat import DivergedError, hear, wants
from deformpush.experiment.run import put_up, read_unfinished, reload
from deformpush.loop import Episode
from deformpush.mechanics import rounding
from deformpush.push_record import PushRecord
from deformpush.record import regret_table
from deformpush.record.folder import RunFolder
from deformpush.record.lock import Lock
from deformpush.record.regret_table import PUSHES, RegretTable, Row
from deformpush.record.unfinished import UnfinishedRun
from deformpush.state import Proposal
from deformpush.study.push_regret import Trials

Array = np.ndarray
Listener = Callable[[PushRecord], object]

MOST = 4096
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def candidates(n: int, outer: Array) -> Array:
    """Pushes `(n, 2)` spread evenly over the outer bounds `[[lo, hi], [lo, hi]]`, always the same.

    kappa is in the middles of n equal parts. Every other push has d_max, near which the best push mostly
    lies; those between have d in equal steps from d_min up, mixed by the golden ratio (a Kronecker
    sequence).
    """
    part = np.arange(n)
    kappa, d = (part + 0.5) / n, np.ones(n)
    between = n // 2
    d[1::2] = np.argsort(np.argsort(np.arange(between) * GOLDEN % 1.0)) / max(1, between)
    lo, hi = outer.T
    return np.clip(rounding.push(lo + np.column_stack([kappa, d]) * (hi - lo)), lo, hi)


def measure(
    run: RunFolder,
    out: Path,
    n: int = PUSHES,
    anew: bool = False,
    listeners: Callable[[int], Listener] = lambda pushes: lambda record: None,
    tell: Callable[[str], None] = lambda line: None,
) -> int:
    """Write regret.csv and regret_trials.csv of a run, or go on with those that are there.

    The optimizer thinks again about every push, so that its forecasts are those it had before it.

    Args:
        run: the run.
        out: folder of the files, which must exist.
        n: pushes tried from each state.
        anew: begin again, whatever is there.
        listeners: given the number of pushes, makes what hears of each that is done.
        tell: hears, in one line, what is to be known of the result.

    Returns:
        How many pushes were there already.

    Raises:
        UserError: the run, its world or the files in `out` do not allow it.
        DivergedError: a push does not end as it was recorded; what was measured before is kept.
        OSError: the files cannot be written.
    """
    if not 1 <= n <= MOST:
        raise UserError(f"pushes = {n}: must be 1 to {MOST}")
    setup, past = reload(run), read_unfinished(run)
    if not past.pushes:
        raise UserError(f"{run.table}: holds no push, so there is none to regret")
    lock = Lock.take(out)
    if lock is None:
        raise UserError(f"{out}: another process is at work in this folder; --out writes elsewhere")
    with ExitStack() as stack:
        stack.callback(lock.release)
        table = _table(out, past, n, anew)
        already = len(table.rows)
        if already == past.pushes:
            return already
        optimizer, cell = put_up(setup, run)
        stack.callback(cell.world.close)
        if "branches" not in cell.world.offers:
            raise UserError(f"world={setup.options['world']}: offers no branches, which regret needs")
        stack.enter_context(one_thread())
        walk = Walk(begin(setup, cell, optimizer), past, table, tell)
        table.open()  # not before: a run that is refused stays as it is
        stack.callback(table.close)
        walk.to_the_end(candidates(n, setup.bounds.outer), listeners(past.pushes))
    return already


class Walk:
    """A run made again, push by push, with other pushes tried before each."""

    def __init__(
        self, episode: Episode, past: UnfinishedRun, table: RegretTable, tell: Callable[[str], None]
    ) -> None:
        """Begin in the state before any push.

        Raises:
            DivergedError: that is not the one of the run.
        """
        self.episode, self.past, self.table, self.tell = episode, past, table, tell
        self._otherwise = False
        hear(past, episode.record)

    def to_the_end(self, U: Array, listener: Listener) -> None:
        """Try pushes U `(n, 2)` from every state whose push has no row yet; errors as in `measure`."""
        for k in range(1, self.past.pushes + 1):
            made = self.past.proposal(k)
            every = np.vstack([U, made.u])
            trials = None if k <= len(self.table.rows) else self._try(every, made)
            before = self.episode.record
            record = self._push(k, made)
            if trials is not None:
                self._write(before, record, trials)
            listener(record)

    def _try(self, U: Array, made: Proposal) -> Trials:
        """What pushes U `(n+1, 2)` would do at the speed of the one made, and what the model says of them."""
        episode, seen = self.episode, self.episode.record.view.seen
        forecast = episode.optimizer.predict(U, episode.state)
        mean, std = (np.full(len(U), np.nan),) * 2 if forecast is None else forecast
        xi = np.full(len(U), np.nan)
        paths = [replace(episode.cell.plan(u, seen), speed=made.speed) for u in U[:-1]]
        followed = [i for i, path in enumerate(paths) if episode.cell.can_follow(path)]
        looks = episode.cell.seen_along([paths[i] for i in followed], seen)
        for i, look in zip(followed, looks, strict=True):
            if look is not None:
                xi[i] = episode.task.errors(look, episode.target).e_T - episode.record.errors.e_T
        return Trials(U, xi, mean, std)

    def _push(self, k: int, made: Proposal) -> PushRecord:
        """Push k as it was made."""
        try:
            record = self.episode.push(u=made.u, speed=made.speed)
        except (WorldError, PerceptionError) as problem:
            raise DivergedError(self.past, k, str(problem)) from problem
        hear(self.past, record)
        same = self.episode.wanted is not None and np.array_equal(self.episode.wanted, made.u)
        if not same and not self._otherwise and made.phase != PHASE:
            self._otherwise = True
            self.tell(
                f"push {k}: the optimizer {wants(self.episode)}, which is not what the run pushed; from here "
                "on forecasts are those of this version and machine"
            )
        return record

    def _write(self, before: PushRecord, record: PushRecord, trials: Trials) -> None:
        """One row, and one for each push that was tried."""
        assert record.action is not None
        action, so_far = record.action, self.table.rows
        kappa, d = action.u.tolist()
        trials.xi[-1] = action.xi
        found = trials.numbers()
        row: Row = {"k": record.k, "phase": self.past.rows[record.k]["phase"], "kappa": kappa, "d": d}
        row |= {"e_T_before": before.errors.e_T, "xi": action.xi} | found
        row["cumulative_regret"] = found["regret"] + (
            float(so_far[-1]["cumulative_regret"]) if so_far else 0.0
        )
        columns = np.column_stack([trials.U, trials.xi, trials.mean, trials.std])[:-1].tolist()
        names = regret_table.TRIAL_COLUMNS[1:]
        tried: list[Row] = [{"k": record.k} | dict(zip(names, one, strict=True)) for one in columns]
        self.table.append(row, tried)


def _table(out: Path, past: UnfinishedRun, n: int, anew: bool) -> RegretTable:
    """The files to write, as far as they are there.

    Raises:
        UserError: what is there is of something else.
    """
    hint = "--overwrite begins again, --out writes elsewhere"
    try:
        table = RegretTable(out, n, anew)
    except ValueError as error:
        raise UserError(f"{error}; {hint}") from error
    for k, row in enumerate(table.rows, start=1):
        if k > past.pushes or any(row[name] != past.rows[k][name] for name in ("kappa", "d", "xi")):
            raise UserError(f"{out / regret_table.REGRET}: row {k} is not of {past.folder.path}; {hint}")
    return table
