"""The one object the runner knows of everything that is written during a run."""

import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from time import perf_counter
from types import TracebackType
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import Interval

from deformpush.push_record import PushRecord, RunInfo
from deformpush.record import checkpoint
from deformpush.record.folder import FORECASTS, SUMMARY, RunFolder
from deformpush.record.forecasts import Forecasts
from deformpush.record.lock import Lock
from deformpush.record.parts import next_part
from deformpush.record.picture import encode
from deformpush.record.poses import TraceWriter
from deformpush.record.summary import Status, Summary, strains
from deformpush.record.table import Table
from deformpush.record.unfinished import Past
from deformpush.viewer.address import ADDRESS, SPAWNED

if TYPE_CHECKING:
    from deformpush.viewer.stream import Stream

TIMED = ("step_s", "render_s", "decide_s")
"""Durations that a `PushRecord` brings along."""


@dataclass
class Recorder:
    """Writes table, contours, pictures and the Rerun stream; use it as a context manager.

    Whatever ends the run, what was recorded up to the last push stays valid and summary.json says how it
    ended: leaving the block by an exception (Ctrl-C included) writes `failed` with its text.
    """

    folder: RunFolder
    rrd: bool = True
    """Write recording.rrd."""
    scene: bool = True
    """Record the 3D scene: mesh, table, arm or tool."""
    motion: bool = True
    """Record the moments inside each push."""
    maps: bool = True
    """Record mean, sigma and acquisition over (kappa, d)."""
    image_px: Annotated[int, Interval(ge=64, le=2048)] = 480
    """Width of the bottom view in the recording (px)."""
    jpeg_quality: Annotated[int, Interval(ge=10, le=100)] = 85
    figures: bool = True
    """Draw figures/ at the end."""
    spawn: bool = False
    """Show the run live in a viewer window."""
    connect: str | None = None
    """Show it live in a viewer that listens at this address."""

    _held: ExitStack = field(default_factory=ExitStack, init=False, repr=False)
    _info: RunInfo | None = field(default=None, init=False, repr=False)
    _before_s: float = field(default=0.0, init=False, repr=False)
    _resumed: int | None = field(default=None, init=False, repr=False)
    _steps: int = field(default=0, init=False, repr=False)
    _strain_peaks: list[float] = field(default_factory=list, init=False, repr=False)
    _summary: Summary | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        self._seconds = dict.fromkeys((*TIMED, "record_s"), 0.0)
        if self.connect is not None and not re.fullmatch(ADDRESS, self.connect):
            raise ValueError(
                f"connect: {self.connect!r} is no address of a viewer, such as {SPAWNED} (null for none)"
            )

    def open(self, info: RunInfo, row0: PushRecord, lock: Lock | None = None) -> float:
        """Claim the folder and start all files with the state before any push. Returns the seconds this took.

        With `lock`, already held, the folder is that of a run which ended before it wrote anything.

        Raises:
            FolderError: another run took the folder meanwhile, or it cannot be written.
        """
        self._began = began = perf_counter()
        if lock is None:
            lock = self.folder.claim()
        else:
            self.folder.furnish()
        self._held.callback(lock.release)
        self._trace = TraceWriter(self.folder, info)
        self._trace.add(row0, picture := self._picture(row0))
        self._stream = self._open_stream(info, row0, picture, self.folder.recording)
        self._forecasts = Forecasts(self.folder.path / FORECASTS)
        self._table = Table(self.folder.table, row0, perf_counter() - began)
        self._held.callback(self._table.close)
        self._held.callback(self._forecasts.close)
        self._info = info
        return self._count(row0, perf_counter() - began)

    def reopen(self, info: RunInfo, past: Past, again: Sequence[PushRecord], lock: Lock) -> None:
        """Take up a run after the pushes that `past` tells of.

        Args:
            info: about the run.
            past: its rows.
            again: the same states, made again: row 0, then one per push.
            lock: of the folder, already held.
        """
        self._began = perf_counter()
        self._held.callback(lock.release)
        self.folder.note_resumption(past.pushes)
        self._trace = TraceWriter(self.folder, info)
        pictures = [self._picture(record) for record in again]
        for record, picture in zip(again, pictures, strict=True):
            self._trace.keep(record, picture)
        self._trace.close()
        self._stream = self._open_stream(info, again[0], pictures[0], next_part(self.folder.recording))
        if self._stream is not None:
            self._stream.catch_up(again[1:])
        self._forecasts = Forecasts.reopen(self.folder.path / FORECASTS, past.pushes)
        self._table = Table.reopen(self.folder.table, len(past.rows))
        self._held.callback(self._table.close)
        self._held.callback(self._forecasts.close)
        for row, record in zip(past.rows, again, strict=True):
            self._count(replace(record, **{name: row[name] for name in TIMED}), row["record_s"])
        self._before_s = sum(self._seconds.values())
        self._resumed = past.pushes
        self._info = info

    def push(self, record: PushRecord, knows: Mapping[str, Any] | None = None) -> float:
        """Record push k. Returns the seconds it took, the table's own write included.

        Its row in pushes.csv comes when all else is written: what has no row did not happen. Only the
        checkpoint, `knows` (the optimizer's state after the push), follows, and is never ahead of the table.

        Raises:
            OSError: no room or no permission.
        """
        began = perf_counter()
        self._trace.add(record, picture := self._picture(record))
        self._forecasts.append(record)
        if self._stream is not None:
            self._stream.push(record, self._smaller(record, picture))
        self._table.append(record, perf_counter() - began)
        seconds = self._count(record, perf_counter() - began)
        if knows is not None:
            checkpoint.write(self.folder.checkpoint, record.k, knows)
        return seconds

    def close(self, status: Status, reason: str, wall_s: float | None = None) -> Summary:
        """Write summary.json and the figures and release the files.

        Args:
            status: reached, budget or failed.
            reason: one line for people.
            wall_s: duration of the run; by default since `open`.
        """
        assert self._info is not None, "close comes after open"
        self._table.close()
        self._forecasts.close()
        self._trace.close()
        info, last = self._info, self._last
        strained = strains(self._strain_peaks, info.strain_limit)
        self._summary = Summary(
            status=status,
            reason=reason,
            pushes=last.k,
            initial_samples=info.initial_samples,
            seed=info.seed,
            object=info.object_name,
            model=info.model,
            acquisition=info.acquisition,
            wall_s=self._before_s + perf_counter() - self._began if wall_s is None else wall_s,
            e_c=last.e_c,
            e_theta=last.e_theta,
            e_gamma=last.e_gamma,
            e_T=last.e_T,
            position_error_m=last.position_error_m,
            angle_error_rad=last.angle_error_rad,
            steps=self._steps,
            calibration=self._forecasts.calibration,
            resumed=self._resumed,
            strain_limit=info.strain_limit,
            strain_peak=strained.peak,
            exceedances=strained.exceedances,
            strain_dose=strained.dose,
            **self._seconds,
        )
        self.folder.write_json(SUMMARY, asdict(self._summary))
        if self._stream is not None and status != "interrupted":  # what is resumed gets another part
            self._stream.close()
        if self.figures:
            from deformpush.study import run_figure as figures

            figures.draw(self.folder)
        self._held.close()
        return self._summary

    def __enter__(self) -> "Recorder":
        """Nothing is opened before `open`."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        """End a run that did not end itself."""
        try:
            if self._info is not None and self._summary is None:
                self._end(error)
        finally:
            self._held.close()  # however far things came: the process may go on with other runs

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

    def _count(self, record: PushRecord, seconds: float) -> float:
        self._last = record
        for name in TIMED:
            self._seconds[name] += getattr(record, name)
        self._seconds["record_s"] += seconds
        self._steps += record.steps
        if record.strain is not None:
            self._strain_peaks.append(record.strain.p99_peak)
        return seconds

    def _open_stream(self, info: RunInfo, row0: PushRecord, picture: bytes, path: Path) -> "Stream | None":
        if not (self.rrd or self.spawn or self.connect):
            return None
        from deformpush.viewer.stream import Stream

        stream = Stream(
            path if self.rrd else None,
            info,
            row0,
            self._smaller(row0, picture),
            scene=self.scene,
            motion=self.motion,
            maps=self.maps,
            image_px=min(self.image_px, info.camera.pixels),
            spawn=self.spawn,
            connect=self.connect,
        )
        self._held.callback(stream.release)
        return stream

    def _picture(self, record: PushRecord) -> bytes:
        return encode(record.after.image, record.after.image.shape[1], self.jpeg_quality)

    def _smaller(self, record: PushRecord, picture: bytes) -> bytes:
        image = record.after.image
        return picture if image.shape[1] <= self.image_px else encode(image, self.image_px, self.jpeg_quality)
