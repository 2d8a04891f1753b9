"""recording.rrd: the Rerun stream of one run, saved, shown live, or both."""

import logging
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import rerun as rr

from deformpush.push_record import PushRecord, RunInfo
from deformpush.record.folder import RECORDING, parts
from deformpush.record.pictures import encode
from deformpush.record.settings import RecordSettings
from deformpush.viewer.blueprint import blueprint
from deformpush.viewer.bottom_view import BottomView, around
from deformpush.viewer.compact import CLOSE_S, check_room, compact, identity_of, let_go
from deformpush.viewer.forecast import ForecastPanel
from deformpush.viewer.inside_push import InsidePush
from deformpush.viewer.legends import Legends
from deformpush.viewer.live import viewers
from deformpush.viewer.model_maps import ModelMaps
from deformpush.viewer.panel import Panel, set_time
from deformpush.viewer.plots import Plots
from deformpush.viewer.scene import Scene
from deformpush.viewer.text import Text

ROOM_M = 0.08
"""About the object and its goal in the bottom view, for pushes that lead away."""

log = logging.getLogger(__name__)


def application(scene: bool, maps: bool) -> str:
    """Name that recordings of one layout share: a viewer keeps one layout for each name."""
    return "deformpush" + ("" if scene else "-without-scene") + ("" if maps else "-without-maps")


@contextmanager
def _silence() -> Iterator[None]:
    """Keep off the terminal what Rerun's own log warns of: that the file is to have no footer."""
    try:
        terminal = os.dup(2)
    except OSError:  # there is none
        yield
        return
    try:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(terminal, 2)
        os.close(terminal)


class Stream:
    """What was decided for push k (arrow, maps, phase) stands at the state it was decided in, k - 1.

    Its outcome stands at k. The stream is flushed after every push, so the file of a killed run opens up to
    there.
    """

    def __init__(
        self, path: Path, info: RunInfo, first: PushRecord, picture: bytes, settings: RecordSettings
    ) -> None:
        """Open the file and the live viewers, log what never changes and the first state.

        Args:
            path: the file, if one is to be written.
            info: about the run.
            first: row 0.
            picture: its bottom view (JPEG), as wide as the camera sees it.
            settings: what to record and where to show it.
        """
        self._settings, self._path = settings, path
        if settings.rrd:
            check_room(path.parent)
        scene, maps, width = settings.scene, settings.maps, min(settings.image_px, info.camera.pixels)
        before = parts(path.with_name(RECORDING)) if settings.rrd else []
        identity = identity_of(before[0]) if before else None
        self._rec = rr.RecordingStream(application(scene, maps), recording_id=identity)
        self._rec.set_log_tick_enabled(False)
        self._rec.set_log_time_enabled(False)
        seen, target = first.view.seen, info.target
        bounds = around(info.camera, width, np.concatenate([seen.contour, target.outline]), ROOM_M)
        x, y = ((seen.c + target.c) / 2).tolist()
        strain = first.view.strain is not None
        self._legends = Legends()
        self._layout = partial(blueprint, info, scene, maps, bounds, (x, y), strain=strain)
        # A footer would list every chunk, and grow with the run in memory; the compacted file gets one.
        sinks: list[rr.FileSink | rr.GrpcSink] = (
            [rr.FileSink(path, write_footer=False)] if settings.rrd else []
        )
        sinks += [rr.GrpcSink(address) for address in viewers(settings.spawn, settings.connect)]
        if sinks:
            with _silence():
                self._rec.set_sinks(*sinks, default_blueprint=self._layout())
        self._rec.send_recording_name(info.title)
        text = Text(scene, settings.motion, maps, strain)
        self._panels: list[Panel] = [BottomView(width), Plots(self._legends), text]
        self._panels += [ForecastPanel(width, self._legends)] if info.options["model"] == "motion" else []
        self._panels += [Scene()] if scene else []
        self._panels += [InsidePush(width)] if settings.motion else []
        self._panels += [ModelMaps()] if maps else []
        for panel in self._panels:
            panel.begin(self._rec, info, first)
        still = rr.EncodedImage.from_fields(media_type="image/jpeg", draw_order=0)
        self._rec.log("camera/image", still, static=True)
        self._arrive(first, picture)

    def catch_up(self, records: Iterable[PushRecord]) -> None:
        """Let the panels know of the newest pushes that an earlier part of the recording already shows."""
        nowhere = rr.RecordingStream("nowhere")
        for record in records:
            for panel in self._panels:
                if record.action is not None:
                    panel.decide(nowhere, record.action)
                panel.arrive(nowhere, record)
            self._time_s = record.timing.sim_time_s

    def push(self, record: PushRecord, picture: bytes) -> None:
        """Add push k: its decision at k - 1, its motion in between, its outcome and picture (JPEG) at k.

        Raises:
            OSError: no room on the disk.
        """
        if self._settings.rrd:
            check_room(self._path.parent)
        if (action := record.action) is not None:
            set_time(self._rec, record.k - 1, self._time_s)
            for panel in self._panels:
                panel.decide(self._rec, action)
                if self._settings.motion and action.outcome.motion:
                    panel.move(self._rec, action.outcome.motion, self._time_s)
        self._arrive(record, picture)

    def close(self) -> None:
        """End the file properly and make it small. A viewer that went away meanwhile is not waited for."""
        try:
            self._rec.flush(timeout_sec=CLOSE_S)
        except RuntimeError as error:
            log.warning("the recording, or a live viewer, lacks the end of the run (%s)", error)
        self.release()
        if self._settings.rrd:
            whole = self._path.with_name(RECORDING)
            try:
                compact(parts(whole), whole, self._layout(legends=self._legends.free()))
            except (OSError, RuntimeError, ValueError) as error:
                log.warning("%s stays as it was written (%s)", self._path, error)

    def release(self) -> None:
        """Let go of the file and the viewers."""
        let_go(self._rec)

    def _arrive(self, record: PushRecord, picture: bytes) -> None:
        self._time_s, image = record.timing.sim_time_s, record.view.picture
        if image.shape[1] > self._settings.image_px:
            picture = encode(image, self._settings.image_px, self._settings.jpeg_quality)
        set_time(self._rec, record.k, self._time_s)
        self._rec.log("camera/image", rr.EncodedImage.from_fields(blob=picture))
        for panel in self._panels:
            panel.arrive(self._rec, record)
        self._rec.flush(timeout_sec=0)  # started, not waited for: the disk works while the next push begins
