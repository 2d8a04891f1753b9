"""Whoever listens to a run and writes all of it down: its table, contours, pictures, recording, summary."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from types import TracebackType
from typing import TYPE_CHECKING, Any

from deformpush.push_record import PushRecord, RunInfo
from deformpush.record import checkpoint, summary
from deformpush.record.folder import FORECASTS, RunFolder, next_part
from deformpush.record.forecasts import Forecasts
from deformpush.record.kept import NO_PICTURE
from deformpush.record.lock import Lock
from deformpush.record.pictures import encode
from deformpush.record.poses import PosesWriter
from deformpush.record.settings import RECENT, RecordSettings
from deformpush.record.states import State, state_of
from deformpush.record.summary import Status, Summary, Totals
from deformpush.record.table import Table, cells
from deformpush.record.unfinished import UnfinishedRun
from deformpush.record.world_states import WorldStatesWriter
from deformpush.viewer.null import NullStream

if TYPE_CHECKING:
    from deformpush.viewer.stream import Stream

Knows = Callable[[], Mapping[str, Any]]
"""What the optimizer knows now, as `Optimizer.state` tells it."""
Saves = Callable[[], bytes]
"""What the world is now, as `World.save` tells it."""


class Recorder:
    """Writes a run folder; opened once, then called with each push, as a context manager.

    Whatever ends the run, what was recorded up to the last push stays valid and summary.json says how it
    ended: leaving the block by an exception (Ctrl-C included) writes `failed` with its text.
    """

    def __init__(self, folder: RunFolder, settings: RecordSettings, saves: Saves | None = None) -> None:
        """Take folder and settings; nothing is written before `open` or `reopen`.

        Args:
            folder: where to.
            settings: what is recorded.
            saves: the state of the world, where it can be saved.
        """
        self.folder, self.settings = folder, settings
        self._held = ExitStack()
        self._worlds: WorldStatesWriter | None = None
        if saves is not None and settings.world_states:
            self._worlds = WorldStatesWriter(folder.world_states, saves)
            self._held.callback(self._worlds.close)
        self._totals = Totals()
        self._info: RunInfo | None = None
        self._knows: Knows | None = None
        self._again: list[State] = []
        self._recalled: int | None = None
        self._recent: deque[PushRecord] = deque(maxlen=RECENT)
        self._before_s = 0.0
        self._resumed: int | None = None
        self._summary: Summary | None = None

    def open(self, info: RunInfo, first: PushRecord, knows: Knows, lock: Lock | None = None) -> float:
        """Claim the folder and start all files with the state before any push. Returns the seconds this took.

        Args:
            info: about the run.
            first: row 0.
            knows: what the optimizer knows after each push, for the checkpoint.
            lock: of the folder, already held: it is that of a run which ended before it wrote anything.

        Raises:
            FolderError: another run took the folder meanwhile, or it cannot be written.
        """
        self._began = began = perf_counter()
        if lock is None:
            lock = self.folder.claim()
        else:
            self.folder.furnish()
        self._held.callback(lock.release)
        picture = self._picture(first)
        self._poses = PosesWriter(self.folder, info, [state_of(first, picture)])
        self._held.callback(self._poses.release)
        self._stream = self._show(info, first, picture, self.folder.recording)
        self._forecasts = Forecasts(self.folder.path / FORECASTS)
        self._held.callback(self._forecasts.close)
        if self._worlds is not None:
            self._worlds.begin()
            self._worlds.append(first.k, first.timing.sim_time_s)
        self._table = Table(self.folder.table, first, perf_counter() - began)
        self._held.callback(self._table.close)
        seconds = self._count(first, perf_counter() - began)
        self._info = info
        self._knows = knows
        return seconds

    def remember(self, record: PushRecord) -> None:
        """Hear of a state of an earlier part of the run, made again: row 0, then one per push.

        Nothing is written, and little kept of each, before `reopen`.
        """
        self._keep(record, state_of(record, self._picture(record)))
        if self._worlds is not None:
            self._worlds.put_aside(record.k, record.timing.sim_time_s)

    def recall(self, record: PushRecord, state: State) -> None:
        """Hear of a state of an earlier part of the run that is not made again, before any that is.

        Args:
            record: the push as the files tell of it.
            state: what they keep of it.
        """
        self._keep(record, state)
        self._recalled = record.k

    def reopen(
        self,
        info: RunInfo,
        unfinished: UnfinishedRun,
        knows: Knows | None,
        lock: Lock,
        shown: Iterable[tuple[PushRecord, bytes]] | None = None,
    ) -> None:
        """Take up a run after the pushes it made, which `remember` has heard of.

        Args:
            info: about the run.
            unfinished: its rows.
            knows: as in `open`; None: nobody knows, and no checkpoint is written.
            lock: of the folder, already held.
            shown: the pushes until now and their pictures (JPEG), if no part of the recording has them yet.
        """
        self._began = perf_counter()
        self._held.callback(lock.release)
        self.folder.note_resumption(unfinished.pushes)
        self._poses = PosesWriter(self.folder, info, self._again)
        self._held.callback(self._poses.release)
        first = self._again[0].picture
        self._again.clear()
        self._stream = self._show(info, self._first, first, next_part(self.folder.recording))
        if shown is None:
            self._stream.catch_up(self._recent)
        else:
            for record, picture in shown:
                self._stream.push(record, picture)
        self._forecasts = Forecasts.reopen(self.folder.path / FORECASTS, unfinished.pushes)
        self._held.callback(self._forecasts.close)
        if self._worlds is not None:
            self._worlds.go_on(self._recalled)
        self._table = Table.reopen(self.folder.table, len(unfinished.rows))
        self._held.callback(self._table.close)
        for row in unfinished.rows:
            self._totals.add(row)
        self._before_s = sum(self._totals.seconds.values())
        self._resumed = unfinished.pushes
        self._info, self._knows = info, knows

    def __call__(self, record: PushRecord) -> float:
        """Record push k. Returns the seconds it took, the table's own write included.

        Its row in pushes.csv comes when all else is written: what has no row did not happen. Only the
        checkpoint follows, and is never ahead of the table.

        Raises:
            OSError: no room or no permission.
        """
        began = perf_counter()
        picture = self._picture(record)
        self._poses.add(state_of(record, picture))
        self._forecasts.append(record)
        self._stream.push(record, picture)
        if self._worlds is not None:
            self._worlds.append(record.k, record.timing.sim_time_s)
        self._table.append(record, perf_counter() - began)
        seconds = self._count(record, perf_counter() - began)
        if self._knows is not None and checkpoint.is_due(record.k):
            checkpoint.write(self.folder.checkpoint, record.k, self._knows())
        return seconds

    def close(self, status: Status, reason: str, wall_s: float | None = None) -> Summary:
        """Write summary.json and release the files.

        Args:
            status: how it ended.
            reason: one line for people.
            wall_s: duration of the run; by default since `open`.
        """
        assert self._info is not None, "close comes after open"
        self._table.close()
        self._forecasts.close()
        with suppress(OSError) if status == "interrupted" else nullcontext():
            self._poses.close()  # or the states stay as they were appended, for whoever goes on
        info, totals = self._info, self._totals
        self._summary = Summary(
            status=status,
            reason=reason,
            pushes=self._last.k,
            initial_samples=info.initial_samples,
            seed=info.seed,
            object=info.options["object"],
            model=info.options["model"],
            acquisition=info.options["acquisition"],
            errors=dict(self._last.errors.values),
            wall_s=self._before_s + perf_counter() - self._began if wall_s is None else wall_s,
            steps=totals.steps,
            calibration=self._forecasts.calibration,
            resumed=self._resumed,
            strain_limit=info.strain_limit,
            strain_peak=max(totals.strains, default=None),
            exceedances=totals.exceedances,
            strain_dose=totals.strain_dose,
            force_limit=info.force_limit,
            force_peak=max(totals.forces, default=None),
            **totals.seconds,
        )
        with suppress(OSError, ValueError):
            self.folder.note_kernels()
        summary.write(self.folder, self._summary)
        if status != "interrupted":  # what is resumed gets another part
            self._stream.close()
        self.release()
        return self._summary

    def __enter__(self) -> "Recorder":
        """Hand out the recorder; files are opened by `open` or `reopen`."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        """End a run that did not end itself."""
        try:
            if self._info is not None and self._summary is None:
                self._end(error)
        finally:
            self.release()  # however far things came: the process may go on with other runs

    def release(self) -> None:
        """Let go of all files, as they are."""
        self._held.close()

    def _end(self, error: BaseException | None) -> None:
        if isinstance(error, KeyboardInterrupt):
            self.close("interrupted", str(error) or "interrupted from the keyboard (Ctrl-C)")
        elif isinstance(error, OSError):
            # Where nothing can be written this fails too; a run without summary.json counts as interrupted.
            with suppress(OSError):
                self.close("interrupted", f"{error.strerror or error}")
        else:
            reason = f"{type(error).__name__}: {error}" if error else "the run ended without a status"
            self.close("failed", reason)

    def _keep(self, record: PushRecord, state: State) -> None:
        if not self._again:
            self._first = record
        else:
            self._recent.append(_slim(record))
        self._last = record
        self._again.append(state)

    def _count(self, record: PushRecord, seconds: float) -> float:
        self._last = record
        self._totals.add(cells(record, seconds))
        return seconds

    def _show(self, info: RunInfo, first: PushRecord, picture: bytes, path: Path) -> "Stream | NullStream":
        if not self.settings.streams:
            return NullStream()
        from deformpush.viewer.stream import Stream

        stream = Stream(path, info, first, picture, self.settings)
        self._held.callback(stream.release)
        return stream

    def _picture(self, record: PushRecord) -> bytes:
        picture = record.view.picture
        return encode(picture, picture.shape[1], self.settings.jpeg_quality)


def _slim(record: PushRecord) -> PushRecord:
    """What the recording needs to know of a push that it shows already: all but pictures and motion."""
    view, action = replace(record.view, picture=NO_PICTURE), record.action
    if action is not None:
        action = replace(action, outcome=replace(action.outcome, motion=[], film=[]), maps={})
    return replace(record, view=view, action=action)
