"""Files as somebody who reads docs/perception.md has them: photographs of a table, and of the sheet."""

from pathlib import Path

import cv2

from benchmarks.real_camera import camera, sheet_views
from benchmarks.rendering import Shot, grain, scene
from deformpush.cell.camera import Camera
from tests.pictures import RECT, placed


def take(folder: Path, *names: str) -> None:
    """Photograph what these names say: fillet.png, table.png; table.jpg and tilted-*.jpg are of the sheet."""
    eye = Camera((0.58, 0.0), 0.7, 3.0, 480)
    wood = grain(eye, (170, 120, 80), 0.3)
    things = {"table.png": [], "fillet.png": [(placed(RECT, 0.6, 0.05, 30), (242, 237, 230))]}
    for name in set(things) & set(names):
        cv2.imwrite(str(folder / name), Shot(noise=2).of(scene(eye, things[name], wood))[..., ::-1])
    if "tilted-*.jpg" in names:
        views = sheet_views(
            camera((0.62, 0.1, -0.8), (0.58, 0, 0)), 5, 0.025, (0.58, 0), Shot(noise=2, blur=0.7)
        )
        for name, view in zip(["table.jpg", *(f"tilted-{n}.jpg" for n in range(4))], views, strict=True):
            cv2.imwrite(str(folder / name), view)
