"""The camera under the transparent table: a pinhole whose optical axis points straight up."""

from dataclasses import dataclass
from typing import Annotated, TypeVar

import numpy as np
from annotated_types import Interval

from deformpush.cell.ranges import Metre, Place

Height = TypeVar("Height", float, np.ndarray)


@dataclass(frozen=True)
class Camera:
    """Where the camera looks and how table points map to its pixels.

    The picture is that of an observer above the table: image x follows table x, image y runs against table y
    (a bottom view mirrored once, so that left and right agree with the table frame).
    Distances are metres; `scale` is exact on the plane `plane_z`, the middle of the object's thickness.
    """

    centre: Place
    """Table point on the optical axis (m)."""
    field: Annotated[float, Interval(ge=0.01, le=10)]
    """Width of the table seen in the picture (m)."""
    distance: Annotated[float, Interval(ge=0.01, le=100)]
    """From the lens up to the table surface (m)."""
    pixels: Annotated[int, Interval(ge=64, le=2048)]
    """Width and height of the square picture (px)."""
    plane_z: Metre = 0.0
    """Height above the table on which metres are measured (m)."""
    rate: Annotated[float, Interval(gt=0, le=100)] = 50.0
    """Pictures a second while the tool pushes."""

    @property
    def scale(self) -> float:
        """Pixels per metre on the measuring plane."""
        return self._scale_at(self.plane_z)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of the pictures that a world takes with it: height, width, 3."""
        return self.pixels, self.pixels, 3

    def rectified(self, picture: np.ndarray) -> np.ndarray:
        """The picture that `to_px` speaks of, made from one that a world took.

        Raises:
            PerceptionError: this camera takes no such pictures.
        """
        return picture

    def through_lens(self, picture: np.ndarray) -> np.ndarray:
        """What a world takes, where that draws the picture `to_px` speaks of: the inverse of `rectified`."""
        return picture

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points `(..., 3)` (m) at any height to pixel coordinates `(..., 2)`, as `to_px` has them."""
        points = np.asarray(points, float)
        scale = self._scale_at(points[..., 2:])
        return (points[..., :2] - self.centre) * scale * (1.0, -1.0) + (self.pixels - 1) / 2

    def to_px(self, points: np.ndarray) -> np.ndarray:
        """Table points `(..., 2)` (m) to continuous pixel coordinates (pixel centres at whole numbers)."""
        relative = (np.asarray(points, float) - self.centre) * self.scale
        return relative * (1.0, -1.0) + (self.pixels - 1) / 2

    def to_m(self, points_px: np.ndarray) -> np.ndarray:
        """Inverse of `to_px`: pixel coordinates `(..., 2)` to table points in metres."""
        relative = (np.asarray(points_px, float) - (self.pixels - 1) / 2) * (1.0, -1.0)
        return relative / self.scale + self.centre

    def to_picture(self, points: np.ndarray, width: int | None = None) -> np.ndarray:
        """Pixels `(..., 2)` from the corner of the first one, in the picture drawn `width` pixels wide."""
        return (self.to_px(points) + 0.5) * ((width or self.pixels) / self.pixels)

    def sees(self, points: np.ndarray, border_px: float = 0.0) -> bool:
        """Whether all table points lie inside the picture, `border_px` away from its rim."""
        px = self.to_px(points)
        return bool(np.all(px >= border_px) and np.all(px <= self.pixels - 1 - border_px))

    def _scale_at(self, z: Height) -> Height:
        """Pixels per metre at heights z (m); the lens is below the table, so what is lower is nearer."""
        return self.pixels / self.field * self.distance / (self.distance + z)
