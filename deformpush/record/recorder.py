"""The one object the runner knows of everything that is written during a run."""

import re
from dataclasses import asdict, dataclass, field
from time import perf_counter
from types import TracebackType
from typing import TYPE_CHECKING, Annotated

from annotated_types import Interval

from deformpush.record.address import ADDRESS, SPAWNED
from deformpush.record.folder import FORECASTS, SUMMARY, RunFolder
from deformpush.record.forecasts import Forecasts
from deformpush.record.picture import encode
from deformpush.record.push_record import PushRecord, RunInfo
from deformpush.record.summary import Status, Summary, strains
from deformpush.record.table import Table
from deformpush.record.trace import TraceWriter

if TYPE_CHECKING:
    from deformpush.record.stream import Stream


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

    _info: RunInfo | None = field(default=None, init=False, repr=False)
    _summary: Summary | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        if self.connect is not None and not re.fullmatch(ADDRESS, self.connect):
            raise ValueError(
                f"connect: {self.connect!r} is no address of a viewer, such as {SPAWNED} (null for none)"
            )

    def open(self, info: RunInfo, row0: PushRecord) -> float:
        """Claim the folder and start all files with the state before any push. Returns the seconds this took.

        Raises:
            FolderError: another run took the folder meanwhile, or it cannot be written.
        """
        self._began = began = perf_counter()
        self.folder.claim()
        self._last = row0
        self._seconds = dict.fromkeys(("step_s", "render_s", "decide_s", "record_s"), 0.0)
        self._steps = 0
        self._strain_peaks: list[float] = []
        self._trace = TraceWriter(self.folder, info)
        self._trace.add(row0, picture := self._picture(row0))
        self._stream = self._open_stream(info, row0, picture)
        self._forecasts = Forecasts(self.folder.path / FORECASTS)
        self._table = Table(self.folder.table, row0, perf_counter() - began)
        self._info = info
        return self._count(row0, perf_counter() - began)

    def push(self, record: PushRecord) -> float:
        """Record push k. Returns the seconds it took, the table's own write included."""
        began = perf_counter()
        self._last = record
        try:
            self._trace.add(record, picture := self._picture(record))
            self._forecasts.append(record)
            if self._stream is not None:
                self._stream.push(record, self._smaller(record, picture))
        finally:
            self._table.append(record, perf_counter() - began)
        return self._count(record, perf_counter() - began)

    def close(self, status: Status, reason: str, wall_s: float | None = None) -> Summary:
        """Write summary.json and the figures and release the files.

        Args:
            status: reached, budget or failed.
            reason: one line for people.
            wall_s: duration of the run; by default since `open`.
        """
        assert self._info is not None, "close comes after open"
        self._table.close()
        self._trace.close()
        self._forecasts.close()
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
            wall_s=perf_counter() - self._began if wall_s is None else wall_s,
            e_c=last.e_c,
            e_theta=last.e_theta,
            e_gamma=last.e_gamma,
            e_T=last.e_T,
            position_error_m=last.position_error_m,
            angle_error_rad=last.angle_error_rad,
            steps=self._steps,
            calibration=self._forecasts.calibration,
            strain_limit=info.strain_limit,
            strain_peak=strained.peak,
            exceedances=strained.exceedances,
            strain_dose=strained.dose,
            **self._seconds,
        )
        self.folder.write_json(SUMMARY, asdict(self._summary))
        if self._stream is not None:
            self._stream.close()
        if self.figures:
            from deformpush.record import figures

            figures.draw(self.folder)
        return self._summary

    def __enter__(self) -> "Recorder":
        """Nothing is opened before `open`."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        """End a run that did not end itself."""
        if self._info is None or self._summary is not None:
            return
        reason = f"{type(error).__name__}: {error}" if error else "the run ended without a status"
        if isinstance(error, KeyboardInterrupt):
            reason = "interrupted from the keyboard (Ctrl-C)"
        self.close("failed", reason)

    def _count(self, record: PushRecord, seconds: float) -> float:
        for name in ("step_s", "render_s", "decide_s"):
            self._seconds[name] += getattr(record, name)
        self._seconds["record_s"] += seconds
        self._steps += record.steps
        if record.strain is not None:
            self._strain_peaks.append(record.strain.p99_peak)
        return seconds

    def _open_stream(self, info: RunInfo, row0: PushRecord, picture: bytes) -> "Stream | None":
        if not (self.rrd or self.spawn or self.connect):
            return None
        from deformpush.record.stream import Stream

        return Stream(
            self.folder.recording if self.rrd else None,
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

    def _picture(self, record: PushRecord) -> bytes:
        return encode(record.after.image, record.after.image.shape[1], self.jpeg_quality)

    def _smaller(self, record: PushRecord, picture: bytes) -> bytes:
        image = record.after.image
        return picture if image.shape[1] <= self.image_px else encode(image, self.image_px, self.jpeg_quality)
