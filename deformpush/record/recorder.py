"""The one object the runner knows of everything that is written during a run."""

from dataclasses import asdict, dataclass, field
from time import perf_counter
from types import TracebackType
from typing import Annotated

import numpy as np
from annotated_types import Interval

from deformpush.record.folder import SUMMARY, RunFolder
from deformpush.record.push_record import PushRecord, RunInfo
from deformpush.record.summary import Status, Summary
from deformpush.record.table import Table
from deformpush.record.trace import TraceWriter


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

    def open(self, info: RunInfo, row0: PushRecord) -> float:
        """Start all files with the state before any push. Returns the seconds this took."""
        self._began = began = perf_counter()
        self._info, self._last = info, row0
        self._seconds = dict.fromkeys(("step_s", "render_s", "decide_s", "record_s"), 0.0)
        self._steps = 0
        self._trace = TraceWriter(self.folder, info)
        self._trace.add(row0, self._picture(row0))
        self._table = Table(self.folder.table, row0, perf_counter() - began)
        return self._count(row0, perf_counter() - began)

    def push(self, record: PushRecord) -> float:
        """Record push k. Returns the seconds it took, the table's own write included."""
        began = perf_counter()
        self._last = record
        try:
            self._trace.add(record, self._picture(record))
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
        info, last = self._info, self._last
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
            **self._seconds,
        )
        self.folder.write_json(SUMMARY, asdict(self._summary))
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
        return seconds

    def _picture(self, record: PushRecord) -> bytes:
        return encode(record.after.image, record.after.image.shape[1], self.jpeg_quality)


def encode(image: np.ndarray, width: int, quality: int) -> bytes:
    """JPEG of an RGB image `(H, W, 3)`, scaled down to at most `width` pixels."""
    import cv2

    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    scale = width / bgr.shape[1]
    if scale < 1:
        bgr = cv2.resize(bgr, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return data.tobytes()
