"""recording.rrd: the Rerun stream of one run, saved, shown live, or both."""

import logging
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import rerun as rr

from deformpush.push_record import PushRecord, RunInfo
from deformpush.record.folder import RECORDING
from deformpush.record.parts import parts
from deformpush.viewer.blueprint import blueprint
from deformpush.viewer.bottom_view import BottomView, around
from deformpush.viewer.compact import CLOSE_S, check_room, compact, identity_of, let_go
from deformpush.viewer.forecast import Outlook
from deformpush.viewer.inside_push import InsidePush
from deformpush.viewer.legends import Corners
from deformpush.viewer.live import viewers
from deformpush.viewer.model_maps import ModelMaps
from deformpush.viewer.panel import Panel
from deformpush.viewer.plots import Series
from deformpush.viewer.scene import Scene
from deformpush.viewer.text import Words
from deformpush.viewer.timelines import set_time

ROOM_M = 0.08
"""About the object and its goal in the bottom view, for pushes that lead away."""

log = logging.getLogger(__name__)


def application(scene: bool, maps: bool) -> str:
    """Name that recordings of one layout share: a viewer keeps one layout for each name."""
    return "deformpush" + ("" if scene else "-without-scene") + ("" if maps else "-without-maps")


class Stream:
    """Two timelines: `push` counts states, `sim_time` also holds the moments inside a push.

    What was decided for push k (arrow, maps, phase) stands at the state it was decided in, k - 1; its outcome
    stands at k. The stream is flushed after every push, so the file of a killed run opens up to there.
    """

    def __init__(
        self,
        path: Path | None,
        info: RunInfo,
        first: PushRecord,
        picture: bytes,
        *,
        scene: bool = True,
        motion: bool = True,
        maps: bool = True,
        image_px: int = 480,
        spawn: bool = False,
        connect: str | None = None,
    ) -> None:
        """Open the file and the live viewers, log what never changes and the first state.

        Args:
            path: the file, or None to show the run live only.
            info: about the run.
            first: row 0.
            picture: its bottom view (JPEG).
            scene: whether to record the 3D scene.
            motion: whether to record the moments inside each push.
            maps: whether to record mean, sigma and acquisition.
            image_px: width of the pictures (px).
            spawn: whether to open a viewer window on this machine.
            connect: address of a listening viewer.
        """
        if path is not None:
            check_room(path.parent)
        name, identity = application(scene, maps), None
        if path is not None and (before := parts(path.with_name(RECORDING))):
            identity = identity_of(before[0])
        self._rec = rr.RecordingStream(name, recording_id=identity)
        self._rec.set_log_tick_enabled(False)
        self._rec.set_log_time_enabled(False)
        begin_and_goal = np.concatenate([first.after.contour, info.goal_outline])
        strain = first.after.strain is not None
        seen = around(info.camera, image_px, begin_and_goal, ROOM_M)
        x, y = ((first.after.c + info.goal_c) / 2).tolist()
        self._path, self._corners = path, Corners()
        self._layout = partial(blueprint, info, scene, maps, seen, (x, y), strain=strain)
        sinks: list[rr.FileSink | rr.GrpcSink] = [rr.FileSink(path)] if path else []
        sinks += [rr.GrpcSink(address) for address in viewers(spawn, connect)]
        if sinks:
            self._rec.set_sinks(*sinks, default_blueprint=self._layout())
        self._rec.send_recording_name(info.title)
        self._scene = Scene() if scene else None
        self._inside = InsidePush(image_px) if motion else None
        words = Words(scene, motion, maps, strain)
        self._panels: list[Panel] = [BottomView(image_px), Series(self._corners), words]
        self._panels += [Outlook(image_px, self._corners)] if info.model == "motion" else []
        self._panels += [self._scene] if self._scene else []
        self._panels += [self._inside] if self._inside else []
        self._panels += [ModelMaps()] if maps else []
        for panel in self._panels:
            panel.begin(self._rec, info, first)
        still = rr.EncodedImage.from_fields(media_type="image/jpeg", draw_order=0)
        self._rec.log("camera/image", still, static=True)
        self._arrive(first, picture)

    def catch_up(self, records: Sequence[PushRecord]) -> None:
        """Let the panels know of pushes that an earlier part of the recording already shows."""
        nowhere = rr.RecordingStream("nowhere")
        for record in records:
            if record.decision is not None:
                for panel in self._panels:
                    panel.decide(nowhere, record.decision)
            for panel in self._panels:
                panel.arrive(nowhere, record)
            self._time_s = record.sim_time_s

    def push(self, record: PushRecord, picture: bytes) -> None:
        """Add push k: its decision at k - 1, its motion in between, its outcome and picture (JPEG) at k.

        Raises:
            OSError: no room on the disk.
        """
        if self._path is not None:
            check_room(self._path.parent)
        if record.decision is not None:
            set_time(self._rec, record.k - 1, self._time_s)
            for panel in self._panels:
                panel.decide(self._rec, record.decision)
        if self._inside is not None and record.motion:
            self._inside.move(self._rec, record.motion, self._time_s)
            if self._scene is not None:
                self._scene.move(self._rec, record.motion, self._time_s)
        self._arrive(record, picture)

    def close(self) -> None:
        """End the file properly and make it small. A viewer that went away meanwhile is not waited for."""
        try:
            self._rec.flush(timeout_sec=CLOSE_S)
        except RuntimeError as error:
            log.warning("the recording, or a live viewer, lacks the end of the run (%s)", error)
        self.release()
        if self._path is not None:
            whole = self._path.with_name(RECORDING)
            try:
                compact(parts(whole), whole, self._layout(corners=self._corners.free()))
            except (OSError, RuntimeError, ValueError) as error:
                log.warning("%s stays as it was written (%s)", self._path, error)

    def release(self) -> None:
        """Let go of the file and the viewers."""
        let_go(self._rec)

    def _arrive(self, record: PushRecord, picture: bytes) -> None:
        self._time_s = record.sim_time_s
        set_time(self._rec, record.k, record.sim_time_s)
        self._rec.log("camera/image", rr.EncodedImage.from_fields(blob=picture))
        for panel in self._panels:
            panel.arrive(self._rec, record)
        self._rec.flush(timeout_sec=0)  # started, not waited for: the disk works while the next push begins
