"""A real camera: its lens and where it stands, and how its pictures become those of the ideal camera."""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import cv2
import numpy as np
from annotated_types import Gt, Interval

from deformpush.cell.camera import Camera
from deformpush.cell.ranges import Metre
from deformpush.cell.segmentation import PerceptionError

Array = np.ndarray
Side = Annotated[int, Interval(ge=64, le=8192)]
Vector = tuple[Metre, Metre, Metre]


class WrongPictureError(PerceptionError):
    """The picture is not from the camera that was calibrated."""

    key = "camera.size"


@dataclass(frozen=True, kw_only=True)
class CalibratedCamera(Camera):
    """The ideal camera whose picture is cut out of that of a real one, as `see --calibrate` found it.

    `centre`, `field`, `pixels` choose what is cut out; whatever stands below says what the real camera sees.
    """

    size: tuple[Side, Side]
    """Width and height of its pictures (px)."""
    focal: tuple[Annotated[float, Gt(0)], Annotated[float, Gt(0)]]
    """Focal length along x and y (px)."""
    axis: tuple[float, float]
    """Where the optical axis meets the picture (px, from the middle of the first pixel)."""
    distortion: tuple[float, float, float, float, float]
    """k1, k2, p1, p2, k3 of the lens, as OpenCV has them."""
    turn: Vector
    """Rotation vector that turns the table frame to the camera's (rad)."""
    shift: Vector
    """The table frame's origin in the camera's frame (m)."""

    def __post_init__(self) -> None:
        if self.place[2] * self._facing[2] >= 0:
            raise ValueError("turn: the camera looks away from the table")

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of its pictures."""
        return self.size[1], self.size[0], 3

    def rectified(self, picture: Array) -> Array:
        """The ideal camera's picture, exact on the plane `plane_z`.

        Raises:
            WrongPictureError: it is of another size than those of this camera.
        """
        if picture.shape != self.shape:
            raise WrongPictureError(
                f"the picture has {picture.shape[1]} x {picture.shape[0]} pixels, the camera was calibrated "
                f"with {self.size[0]} x {self.size[1]}"
            )
        return np.asarray(
            cv2.remap(picture, *self._out_of_lens, cv2.INTER_LINEAR, None, cv2.BORDER_REPLICATE)
        )

    def through_lens(self, picture: Array) -> Array:
        """What it would take where the ideal camera takes this picture."""
        return np.asarray(cv2.remap(picture, *self._into_lens, cv2.INTER_LINEAR, None, cv2.BORDER_REPLICATE))

    def to_raw(self, points: Array) -> Array:
        """Table points `(N, 2)` (m) on the plane `plane_z` to pixels `(N, 2)` of its pictures."""
        high = np.column_stack([points, np.full(len(points), self.plane_z)])
        px, _ = cv2.projectPoints(high, np.array(self.turn), np.array(self.shift), self._matrix, self._lens)
        return np.asarray(px[:, 0])

    def from_raw(self, px: Array) -> Array:
        """Inverse of `to_raw`."""
        straight = cv2.undistortPoints(np.asarray(px, float)[:, None], self._matrix, self._lens)[:, 0]
        rays = np.column_stack([straight, np.ones(len(straight))]) @ self.rotation
        along = (self.plane_z - self.place[2]) / rays[:, 2:]
        return np.asarray((self.place + along * rays)[:, :2])

    @cached_property
    def _out_of_lens(self) -> tuple[Array, Array]:
        """For each pixel of the ideal picture: column and row in the real one."""
        cols, rows = np.meshgrid(*[np.arange(self.pixels, dtype=float)] * 2)
        return _maps(self.to_raw(self.to_m(np.column_stack([cols.ravel(), rows.ravel()]))), cols.shape)

    @cached_property
    def _into_lens(self) -> tuple[Array, Array]:
        """For each pixel of the real picture: column and row in the ideal one."""
        cols, rows = np.meshgrid(*[np.arange(side, dtype=float) for side in self.size])
        return _maps(self.to_px(self.from_raw(np.column_stack([cols.ravel(), rows.ravel()]))), cols.shape)

    @property
    def _matrix(self) -> Array:
        (fx, fy), (cx, cy) = self.focal, self.axis
        return np.array([(fx, 0, cx), (0, fy, cy), (0, 0, 1.0)])

    @property
    def _lens(self) -> Array:
        return np.array(self.distortion)

    @cached_property
    def rotation(self) -> Array:
        """From the table frame to the camera's `(3, 3)`."""
        return np.asarray(cv2.Rodrigues(np.array(self.turn))[0])

    @property
    def place(self) -> Array:
        """Of the lens `(3,)` (m, table frame)."""
        return -self.rotation.T @ np.array(self.shift)

    @property
    def _facing(self) -> Array:
        """Direction of the optical axis `(3,)`, table frame."""
        return self.rotation[2]


def _maps(px: Array, shape: tuple[int, ...]) -> tuple[Array, Array]:
    return px[:, 0].reshape(shape).astype(np.float32), px[:, 1].reshape(shape).astype(np.float32)
