"""Worlds of a user's own, as they would stand beside the user's YAML, with no more than a world must have."""

from pathlib import Path

WORLD = """\
from dataclasses import dataclass

import cv2
import numpy as np
from deformpush import Outcome, World, WorldError

@dataclass(frozen=True)
class Mine:
    margin: float = 0.0
    def build(self, sheet, robot, camera, tool_radius):
        return Sheet(sheet, camera)

class Sheet(World):
    def __init__(self, sheet, camera):
        self.outline, self.c, self.camera = sheet.polygon, np.array(sheet.start), camera
    def picture(self):
        white = np.full((self.camera.pixels, self.camera.pixels, 3), 255, np.uint8)
        return cv2.fillPoly(white, [np.int32(self.camera.to_px(self.outline + self.c))], (26, 64, 230))
    def push(self, path):
        if not self.can_reach(path.end[None]).all():
            raise WorldError("out of reach")
        self.c = self.c + path.d * path.direction
        return Outcome()
    def can_reach(self, points):
        return np.linalg.norm(points - (0.58, 0.0), axis=1) < 0.5
"""

BARE = '''\
import numpy as np
from deformpush import Outcome, World

class Bare(World):
    """One that needs no other part: such as a robot, which has its own camera and object."""

    def __init__(self, x: float, y: float):
        self.c = np.array([x, y])
    def picture(self):
        picture = np.full((480, 480, 3), 255, np.uint8)
        column, row = ((self.c - (0.58, 0.0)) * (1, -1) * 480 / 0.7 + 239.5).astype(int)
        picture[row - 34 : row + 35, column - 68 : column + 69] = (26, 64, 230)
        return picture
    def push(self, path):
        self.c = self.c + path.d * path.direction
        return Outcome()
    def can_reach(self, points):
        return np.ones(len(points), bool)
'''


def own_folder(folder: Path) -> Path:
    """A folder for --config-dir, with `world=mine` and `world=bare`."""
    (folder / "world").mkdir(parents=True)
    (folder / "my_world.py").write_text(WORLD)
    (folder / "world" / "mine.yaml").write_text("_target_: my_world.Mine\n")
    (folder / "bare_world.py").write_text(BARE)
    (folder / "world" / "bare.yaml").write_text("_target_: bare_world.Bare\nx: 0.58\ny: -0.1\n")
    return folder
