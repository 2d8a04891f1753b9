"""Entities `model/*`: what the optimizer believed over (kappa, d) when it chose the next push."""

from collections import deque

import numpy as np
import rerun as rr

from deformpush.push_record import Action, PushRecord, RunInfo
from deformpush.record import palette
from deformpush.record.settings import RECENT
from deformpush.viewer.panel import Panel

WIDTH, HEIGHT = 100.0, 36.0
"""Extent of a map in the units of its view: kappa runs to the right, d upwards (y down to 0)."""
GAP = 3.0
"""Distance of the axis labels from the map."""


class ModelMaps(Panel):
    """Mean, sigma and acquisition as pictures, with the last pushes made, the bounds and the choice on each.

    Marks and axes are the same for the three and are logged once; the views show them on each map.
    """

    def __init__(self) -> None:
        """No push is known yet."""
        self._data: deque[np.ndarray] = deque(maxlen=RECENT)
        self._shapes: dict[str, tuple[int, ...]] = {}

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log axes and how marks are drawn."""
        self._outer = info.outer_bounds
        dots = rr.Points2D.from_fields
        strip = np.stack([np.linspace(0, WIDTH, 101), np.full(101, HEIGHT + GAP / 2)], 1)
        kappa, d = info.outer_bounds[0], info.outer_bounds[1] * 1e3
        ticks = [(WIDTH * share, HEIGHT + GAP) for share in (0, 0.5, 1)] + [
            (-8.0, y) for y in (0, HEIGHT - 7.0)
        ]
        texts = [
            f"{kappa[0]:g}",
            f"kappa {kappa.mean():g}",
            f"{kappa[1]:g}",
            f"d {d[1]:g} mm",
            f"{d[0]:g} mm",
        ]
        static = {
            "axes/strip": dots(
                positions=strip, colors=palette.ramp(np.linspace(0, 1, 101), palette.ALONG), radii=0.5
            ),
            "axes/labels": dots(
                positions=ticks, labels=texts, colors=palette.LABEL, radii=0.01, show_labels=True
            ),
            "data": dots(colors=(0, 0, 0), radii=-2.0, draw_order=10),
            "chosen": dots(colors=palette.NEXT_PUSH, radii=-5.0, draw_order=20),
            "bounds": rr.Boxes2D.from_fields(colors=(0, 0, 0), radii=-1.0, draw_order=15),
        }
        for name, what in static.items():
            rec.log(f"model/{name}", what, static=True)

    def decide(self, rec: rr.RecordingStream, action: Action) -> None:
        """Log the maps with the pushes made so far, the bounds and the choice."""
        if not action.maps:
            return
        self._map(rec, "mean", action.maps["mean"], palette.BALANCE, balanced=True)
        self._map(rec, "std", action.maps["std"], palette.RAMP)
        self._map(rec, "acq", action.maps["acq"], palette.RAMP[::-1])
        low, high = self._at(action.proposal.bounds.T)
        box = rr.Boxes2D.from_fields(centers=[(low + high) / 2], half_sizes=[np.abs(high - low) / 2])
        rec.log("model/bounds", box)
        rec.log(
            "model/data", rr.Points2D.from_fields(positions=self._at(np.array(self._data).reshape(-1, 2)))
        )
        chosen = self._at(action.u[None])
        rec.log("model/chosen", rr.Points2D.from_fields(positions=chosen))

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Keep the push that was made for the next maps."""
        if record.action is not None:
            self._data.append(record.action.u)

    def _map(
        self,
        rec: rr.RecordingStream,
        name: str,
        values: np.ndarray,
        colours: tuple[palette.Colour, ...],
        balanced: bool = False,
    ) -> None:
        """Log one map `(n_d, n_kappa)`, grey where nan; a balanced one has zero in mid-colour."""
        if values.shape != self._shapes.get(name):
            self._shapes[name] = values.shape
            self._style(rec, name, values.shape, colours)
        known = np.isfinite(values)
        low, high = (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 0.0)
        if balanced:
            high = max(-low, high)
            low = -high
        picture = palette.ramp(np.where(known, values - low, 0.0) / max(high - low, 1e-12), colours)
        picture[~known] = palette.CLOSED
        rec.log(f"model/{name}/map", rr.Image.from_fields(buffer=picture[::-1].tobytes()))
        marks = [high, (low + high) / 2, low]
        labels = (
            [f"{value:+.2g}" if balanced else f"{value:.2g}" for value in marks] if known.any() else ["-"] * 3
        )
        rec.log(f"model/{name}/scale/labels", rr.Points2D.from_fields(labels=labels))

    def _style(
        self, rec: rr.RecordingStream, name: str, shape: tuple[int, ...], colours: tuple[palette.Colour, ...]
    ) -> None:
        """Log once what does not change: the size of the picture and the places of the colour scale."""
        height, width = shape
        size = rr.components.ImageFormat(width=width, height=height, color_model="RGB", channel_datatype="U8")
        look = rr.Image.from_fields(format=size, magnification_filter="linear", draw_order=0)
        stretch = rr.Transform3D(scale=(WIDTH / width, HEIGHT / height, 1.0))
        rec.log(f"model/{name}/map", look, stretch, static=True)
        ends = np.array([0.05, 0.5, 0.9]) * HEIGHT
        bar = np.stack([np.full(41, WIDTH + GAP), np.linspace(0, HEIGHT, 41)], 1)
        places = np.stack([np.full(3, WIDTH + 10.0), ends - 4.0], 1)
        scale = rr.Points2D(bar, colors=palette.ramp(np.linspace(1, 0, 41), colours), radii=1.0)
        rec.log(f"model/{name}/scale", scale, static=True)
        labels = rr.Points2D(places, colors=palette.LABEL, radii=0.01, show_labels=True)
        rec.log(f"model/{name}/scale/labels", labels, static=True)

    def _at(self, u: np.ndarray) -> np.ndarray:
        """Pushes `(n, 2)` as (kappa, d) to places on the maps."""
        share = (u - self._outer[:, 0]) / (self._outer[:, 1] - self._outer[:, 0])
        return np.asarray(share * (WIDTH, -HEIGHT) + (0.0, HEIGHT))
