"""Entities `model/*`: what the optimizer believed over (kappa, d) when it chose the next push."""

import numpy as np
import rerun as rr

from deformpush import palette
from deformpush.record.push_record import Decision, PushRecord, RunInfo

MAPS = ("mean", "std", "acq")


class ModelMaps:
    """Mean, sigma and acquisition as pictures, with the pushes made, the bounds and the choice on each.

    Kappa grows to the right and d upwards; the unit is one pixel of the map's grid.
    """

    def __init__(self) -> None:
        """No push is known yet."""
        self._data: list[tuple[float, float]] = []
        self._styled = False

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Remember what the maps span."""
        self._outer = info.outer_bounds

    def _style(self, rec: rr.RecordingStream, maps: dict[str, np.ndarray]) -> None:
        """Log once what the maps have in common: size and style; only contents change afterwards."""
        self._styled = True
        for name, values in maps.items():
            height, width = values.shape
            size = rr.components.ImageFormat(width=width, height=height, color_model="RGB", channel_datatype="U8")
            look = rr.Image.from_fields(format=size, magnification_filter="linear", draw_order=0)
            rec.log(f"model/{name}", look, static=True)
        dots = rr.Points2D.from_fields
        rec.log("model/data", dots(colors=(0, 0, 0), radii=-2.0, draw_order=10), static=True)
        rec.log("model/chosen", dots(colors=palette.NEXT_PUSH, radii=-5.0, draw_order=20), static=True)
        box = rr.Boxes2D.from_fields(colors=(255, 255, 255), radii=-1.0, draw_order=15)
        rec.log("model/bounds", box, static=True)

    def decide(self, rec: rr.RecordingStream, decision: Decision) -> None:
        """Log the maps with the pushes made so far, the bounds and the choice."""
        maps = {name: decision.maps[name] for name in MAPS if name in decision.maps}
        if not maps:
            return
        if not self._styled:
            self._style(rec, maps)
        for name, values in maps.items():
            picture = colour_mean(values) if name == "mean" else colour(values)
            rec.log(f"model/{name}", rr.Image.from_fields(buffer=picture[::-1].tobytes()))
        shape = next(iter(maps.values())).shape
        low, high = self._px(decision.bounds.T, shape)
        chosen = self._px(np.array([[decision.kappa, decision.d]]), shape)
        data = self._px(np.array(self._data).reshape(-1, 2), shape)
        box = rr.Boxes2D.from_fields(centers=[(low + high) / 2], half_sizes=[np.abs(high - low) / 2])
        rec.log("model/bounds", box)
        rec.log("model/data", rr.Points2D.from_fields(positions=data))
        rec.log("model/chosen", rr.Points2D.from_fields(positions=chosen))

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Keep the push that was made for the next maps."""
        if record.decision is not None:
            self._data.append((record.decision.kappa, record.decision.d))

    def _px(self, u: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
        """Pushes `(n, 2)` as (kappa, d) to pixels of a map of `shape` (n_d, n_kappa)."""
        share = (u - self._outer[:, 0]) / (self._outer[:, 1] - self._outer[:, 0])
        return np.asarray(share * (shape[1] - 1, 1 - shape[0]) + (0.5, shape[0] - 0.5))


def colour_mean(values: np.ndarray) -> np.ndarray:
    """Colours of a change of error `(n, m)`: white is zero, blue falls, orange rises."""
    reach = max(float(np.abs(values).max()), 1e-12)
    return palette.ramp((values / reach + 1) / 2, palette.BALANCE)


def colour(values: np.ndarray) -> np.ndarray:
    """Colours of a map `(n, m)` from its lowest to its highest value."""
    low, high = float(values.min()), float(values.max())
    return palette.ramp((values - low) / max(high - low, 1e-12))
