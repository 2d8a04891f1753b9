"""compare.rrd: bottom views of several runs side by side, and their errors in one picture.

Made from the run folders, not from their recordings, which another version of Rerun may have written.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from deformpush.record import palette
from deformpush.record.palette import Colour
from deformpush.record.poses import Poses
from deformpush.task import TERMS, TOTAL
from deformpush.viewer.bottom_view import BottomView, around
from deformpush.viewer.compact import check_room
from deformpush.viewer.panel import PUSH

APPLICATION = "deformpush-compare"
ROOM_M = 0.03
ERRORS = (*TERMS, TOTAL)
"""What is plotted, a panel each."""

Array = np.ndarray


@dataclass(frozen=True)
class Sight:
    """What the camera saw in one run."""

    title: str
    ended: str
    """How the run ended, in a few words."""
    poses: Poses
    pictures: Sequence[bytes]
    """JPEG for every k."""


@dataclass(frozen=True)
class Line:
    """The errors of a run, or the middle of several, over k; by the names of `TERMS` and `TOTAL`."""

    title: str
    colour: Colour
    errors: Mapping[str, Array]
    band: Mapping[str, tuple[Array, Array]] | None = None
    """Lower and upper quartile."""


def save(
    path: Path,
    sights: Sequence[Sight],
    lines: Sequence[Line],
    stops: Mapping[str, Sequence[float]],
    about: str,
) -> None:
    """Write the recording.

    Args:
        path: the file.
        sights: runs to show side by side; one that has ended keeps its last picture.
        lines: what to draw in the panels of the errors.
        stops: values of the stop lines by the name of the error.
        about: what is compared, as Markdown.

    Raises:
        OSError: no room on the disk.
    """
    check_room(path.parent, sum(len(picture) for sight in sights for picture in sight.pictures))
    rec = rr.RecordingStream(APPLICATION)
    rec.set_log_tick_enabled(False)
    rec.set_log_time_enabled(False)
    seen = _everywhere(sights)
    rec.set_sinks(rr.FileSink(path), default_blueprint=_layout(sights, seen))
    rec.send_recording_name(f"comparison of {len(lines)}")
    rec.log("about", rr.TextDocument(about, media_type="text/markdown"), static=True)
    last = max(len(curve) for line in lines for curve in line.errors.values()) - 1
    for error in ERRORS:
        for i, line in enumerate(lines):
            _line(rec, f"errors/{error.name}/{i:03d}", line, error.name)
        for i, stop in enumerate(stops.get(error.name, ())):
            _curves(
                rec,
                f"errors/{error.name}/stop{i}",
                ["stop"],
                palette.STOP,
                [1.0],
                np.full((last + 1, 1), stop),
            )
    for i, sight in enumerate(sights):
        _sight(rec, f"runs/{i}", sight, seen)
    rec.flush()
    rec.disconnect()
    check_room(path.parent)  # somebody else may have taken it meanwhile, of which Rerun does not tell


def _sight(rec: rr.RecordingStream, root: str, sight: Sight, seen: Array) -> None:
    """Log the states of one run as its own recording shows them, and at its end how it ended."""
    poses = sight.poses
    view = BottomView(poses.camera.pixels, root)
    view.lay(rec, poses.camera, poses.goal_outline, poses.goal_c)
    rec.log(f"{root}/image", rr.EncodedImage.from_fields(media_type="image/jpeg", draw_order=0), static=True)
    count = min(len(sight.pictures), len(poses.contours))
    for k in range(count):
        rec.set_time(PUSH, sequence=k)
        rec.log(f"{root}/image", rr.EncodedImage.from_fields(blob=sight.pictures[k]))
        view.outline(rec, poses.contours[k], poses.centroids[k])
        if k + 1 < count and np.isfinite(poses.starts[k + 1]).all():
            view.point(rec, poses.starts[k + 1], poses.ends[k + 1])
    left, below = poses.camera.to_picture(np.array([(seen[0, 0] + seen[1, 0]) / 2, seen[0, 1] + ROOM_M / 2]))
    text = rr.Points2D(
        [(left, below)], labels=sight.ended, colors=palette.INK, radii=0.01, show_labels=True, draw_order=40
    )
    rec.log(f"{root}/ended", text)
    rec.reset_time()


def _line(rec: rr.RecordingStream, path: str, line: Line, error: str) -> None:
    """Log a line, and its band as two thinner ones: of the same name, so that the legend has one entry."""
    values = line.errors[error]
    _curves(rec, path, [line.title], line.colour, [2.0], values[:, None])
    if line.band is not None:
        _curves(rec, f"{path}/band", [line.title] * 2, line.colour, [0.75] * 2, np.stack(line.band[error], 1))


def _curves(
    rec: rr.RecordingStream,
    path: str,
    names: list[str],
    colour: Colour,
    widths: list[float],
    values: Array,
) -> None:
    """Log curves `(K+1, n)` that share an entity, in one batch."""
    style = rr.SeriesLines(names=names, colors=[colour] * len(names), widths=widths)
    rec.log(path, style, static=True)
    times = rr.TimeColumn(PUSH, sequence=np.arange(len(values)))
    count, width = values.shape
    rec.send_columns(path, [times], rr.Scalars.columns(scalars=values.ravel()).partition([width] * count))


def _everywhere(sights: Sequence[Sight]) -> Array:
    """Lowest and highest x and y `(2, 2)` (m) of where the objects were and shall be."""
    paths = [sight.poses for sight in sights]
    places = [np.concatenate([one.goal_outline, *one.contours, one.starts[1:]]) for one in paths]
    every = np.concatenate([*places, np.full((1, 2), np.nan)])
    return np.stack([np.nanmin(every, 0), np.nanmax(every, 0)]) if sights else every


def _layout(sights: Sequence[Sight], seen: Array) -> rrb.Blueprint:
    """Bottom views of the same part of the table, so that they can be compared; the errors; the text."""
    views = [
        rrb.Spatial2DView(
            origin=f"runs/{i}",
            name=sight.title,
            background=(255, 255, 255),
            visual_bounds=around(sight.poses.camera, sight.poses.camera.pixels, seen, ROOM_M),
        )
        for i, sight in enumerate(sights)
    ]
    panels = [
        rrb.TimeSeriesView(
            origin=f"errors/{error.name}",
            name=error.label,
            plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop, visible=error is ERRORS[0]),
            axis_x=rrb.TimeAxis(link="LinkToGlobal"),
        )
        for error in ERRORS
    ]
    text = rrb.TextDocumentView(origin="about", name="What is compared")
    above: list[rrb.View | rrb.Container] = [rrb.Grid(*views)] if views else []
    left = rrb.Vertical(*above, text, row_shares=[0.72, 0.28][-1 - len(above) :])
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*panels), column_shares=[0.55, 0.45]),
        rrb.TimePanel(state="collapsed", timeline=PUSH),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
    )
