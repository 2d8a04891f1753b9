"""What is seen rightly: `python -m benchmarks.seeing` prints the tables of docs/perception.md.

With `--figure` it also draws docs/pictures/seeing.png. Renderings have the camera of `camera=bottom`, 1.46 mm
a pixel. Photographs are those that scikit-image and scikit-learn ship.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import cv2
import numpy as np

from benchmarks.photographs import PHOTOGRAPHS, Photograph, texture
from benchmarks.real_camera import camera as real_camera
from benchmarks.real_camera import sheet_views
from benchmarks.rendering import Shot, cover, grain, scene
from deformpush.cell.background import Background
from deformpush.cell.calibration import calibrate
from deformpush.cell.camera import Camera
from deformpush.cell.perception import Perception
from deformpush.cell.segmentation import PerceptionError
from deformpush.cell.sight import Sight, by_difference, by_place
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.mechanics.geometry import resample, rotation, signed_area

Array = np.ndarray

CAMERA: Camera = config.build(compose([]).camera)
BY_COLOUR: Perception = config.build(compose([]).contour)
BY_TABLE: Perception = config.build(compose(["contour=background"]).contour)
FISH = np.array(config.build(compose(["object=fish_fillet"]).object).polygon)
MEAT = np.array(config.build(compose(["object=meat"]).object).polygon)
BLUE, FILLET, MEAT_RED, WOOD = (26, 64, 230), (242, 237, 230), (120, 50, 45), (170, 120, 80)
WHITE = (255, 255, 255)
SHADOW = (-0.3,) * 3
SHOTS = {
    "as drawn": Shot(),
    "noise, 4 levels": Shot(noise=4),
    "noise, 10 levels": Shot(noise=10),
    "blur, 1.5 px": Shot(blur=1.5),
    "blur, 3 px": Shot(blur=3),
    "corners half as bright": Shot(uneven=0.5),
    "all of these: 4, 1.5, half": Shot(noise=4, blur=1.5, uneven=0.5),
    "yellow light": Shot(light=(1.0, 0.85, 0.6), noise=2),
}
POSES = [(0.62, 0.05, 33), (0.45, -0.12, -70), (0.7, 0.15, 110)]
FIGURE = Path(__file__).parents[1] / "docs" / "pictures" / "seeing.png"


@dataclass(frozen=True)
class Panel:
    """A picture for the figure, and the outlines seen and true in it (px)."""

    title: str
    picture: Array
    seen: Array | None = None
    middle: tuple[float, float] = (0.5, 0.5)
    """Of the part that is shown, as shares of width and height."""
    height: float = 0.6
    """Of that part, as a share of the picture's height."""


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--figure", action="store_true", help=f"draw {FIGURE.name} too")
    given = parser.parse_args()
    panels: list[Panel] = []
    with TemporaryDirectory() as scratch:
        for table in (renderings, textures, photographs, cameras):
            print(table(panels, Path(scratch)), end="\n\n", flush=True)
    if given.figure:
        draw(panels)


def renderings(panels: list[Panel], scratch: Path) -> str:
    """Objects of four kinds, drawn and then taken in eight ways."""
    wood = grain(CAMERA, WOOD, 0.3)
    kinds: dict[str, tuple[Array, tuple[float, float, float], Array | tuple[int, int, int], Perception]] = {
        "blue, `hsv`": (MEAT, BLUE, WHITE, BY_COLOUR),
        "blue": (MEAT, BLUE, WHITE, BY_TABLE),
        "white fillet, white table": (FISH, FILLET, WHITE, BY_TABLE),
        "meat, grey table": (MEAT, MEAT_RED, (190, 190, 185), BY_TABLE),
        "white fillet, wood": (
            FISH,
            FILLET,
            wood,
            on_table(wood, Shot(seed=99, noise=2), scratch / "wood.png"),
        ),
    }
    rows = [["taken with", *kinds], ["---"] * (len(kinds) + 1)]
    for name, shot in SHOTS.items():
        cells = []
        for shape, colour, table, eye in kinds.values():
            results = []
            for n, pose in enumerate(POSES):
                truth = placed(shape, *pose)
                picture = replace(shot, seed=n).of(scene(CAMERA, [(truth, colour)], table))
                results.append(errors(eye, picture, CAMERA, truth))
            cells.append(worst(results))
        rows.append([name, *cells])
    truth = placed(FISH, 0.6, 0.02, 25)
    things = [(placed(FISH, 0.615, 0.007, 25), SHADOW), (truth, FILLET)]
    picture = Shot(noise=3, blur=1, uneven=0.3).of(scene(CAMERA, things, WHITE))
    panels.append(panel("a white fillet on white, with its shadow", picture, BY_TABLE))
    return markdown(rows)


def textures(panels: list[Panel], scratch: Path) -> str:
    """Objects cut out of photographs on tables that are photographs, dimmer than when they were empty."""
    rows = [["table", "object", "area", "Hausdorff (mm)"], ["---"] * 4]
    for table in ("brick", "gravel", "grass"):
        ground = texture(table, CAMERA.pixels)
        eye = on_table(ground, Shot(seed=99, noise=2), scratch / f"{table}.png")
        for name in ("chelsea", "coffee", "flower"):
            truth = placed(FISH if name == "chelsea" else MEAT, *POSES[0])
            share = cover(CAMERA, truth)[..., None]
            whole = ground + share * (texture(name, CAMERA.pixels) - ground)
            picture = Shot(noise=3, blur=0.8, uneven=0.2, light=(0.85, 0.85, 0.8)).of(whole)
            rows.append([table, name, *errors(eye, picture, CAMERA, truth)])
            if title := {("gravel", "chelsea"): "fur on gravel", ("brick", "flower"): "petals on brick"}.get(
                (table, name)
            ):
                panels.append(panel(title, picture, eye))
    return markdown(rows)


def photographs(panels: list[Panel], scratch: Path) -> str:
    """Photographs as they are; the truth is what a person drew around the object."""
    rows = [["photograph", "asked", "seen"], ["---"] * 3]
    for photo in PHOTOGRAPHS:
        picture = photo.picture()
        high, wide = picture.shape[:2]
        camera = Camera((wide / 2e3, (high - wide / 2) / 1e3), wide / 1e3, 3.0, wide)
        try:
            sight = look(photo, picture, camera)
        except PerceptionError as problem:
            rows.append([photo.name, photo.asked, f"refused: {str(problem).partition(':')[0]}"])
            continue
        seen, truth = sight.seen.contour, photo.truth()
        told = f"{1e6 * signed_area(seen):.0f} px; nobody has drawn what is right"
        if truth is not None:
            area, far = compared(seen, camera.to_m(truth))
            size = 1e3 * np.ptp(seen, axis=0).max()
            told = f"area {area:+.1%}, Hausdorff {1e3 * far:.1f} px of {size:.0f} px"
        rows.append([photo.name, photo.asked, told])
        if photo.shown:
            panels.append(Panel("a dahlia that was pointed at", picture, camera.to_px(seen), height=1.0))
    return markdown(rows)


def look(photo: Photograph, picture: Array, camera: Camera) -> Sight:
    """What `see` makes of a photograph."""
    eye = replace(BY_TABLE, min_area=0.002 * picture.shape[0] * picture.shape[1] / camera.scale**2)
    if photo.on is not None:
        return by_place(picture, camera, eye, photo.on)
    assert isinstance(eye.segmentation, Background)
    return by_difference(picture, camera, eye, eye.segmentation)


def cameras(panels: list[Panel], scratch: Path) -> str:
    """A camera with a lens, calibrated from pictures of the sheet, and where it then sees the table."""
    rows = [
        ["camera", "pictures", "told: on the sheet", "told: at the rim", "true: rms", "true: largest"],
        ["---"] * 6,
    ]
    for place in ((0.58, 0.0, -0.8), (0.7, 0.15, -0.8), (0.3, 0.2, 0.75)):
        for count in (5, 10, 20):
            true = real_camera(place, (0.58, 0.0, 0.0))
            side: Literal["above", "below"] = "above" if place[2] > 0 else "below"
            views = sheet_views(true, count, 0.025, (0.58, 0.0), Shot(noise=4, blur=0.8))
            found = calibrate(views, 0.025, (0.58, 0.0), 0.0, side, 50.0)
            steps = np.linspace(-0.5, 0.5, 15) * found.camera.field
            points = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) + found.camera.centre
            off = 1e3 * np.linalg.norm(found.camera.from_raw(true.to_raw(points)) - points, axis=1)
            tilt = np.degrees(np.arctan2(np.hypot(place[0] - 0.58, place[1]), abs(place[2])))
            rows.append(
                [f"{side}, tilted {tilt:.0f} degrees", str(count)]
                + [
                    f"{mm:.2f} mm"
                    for mm in (found.table_mm, found.rim_mm, np.sqrt(np.mean(off**2)), off.max())
                ]
            )
            if (place[2], count) == (0.75, 10):
                panels.append(Panel("the sheet, by a tilted camera", views[0], middle=(0.57, 0.5)))
                panels.append(Panel("the same, rectified", found.camera.rectified(views[0]), height=0.55))
    return markdown(rows)


def placed(shape: Array, x: float, y: float, degrees: float) -> Array:
    """A shape turned about the origin, then moved."""
    return shape @ rotation(np.radians(degrees)).T + (x, y)


def on_table(table: Array, shot: Shot, file: Path) -> Perception:
    """What looks at a table that was taken empty."""
    cv2.imwrite(str(file), shot.of(table)[..., ::-1])
    return replace(BY_TABLE, segmentation=replace(BY_TABLE.segmentation, empty=str(file)))  # type: ignore[type-var]


def errors(eye: Perception, picture: Array, camera: Camera, truth: Array) -> list[str]:
    """Relative error of the area and Hausdorff distance (mm), or what is said instead."""
    try:
        seen = eye.observe(picture, camera).contour
    except PerceptionError:
        return ["not seen", ""]
    area, far = compared(seen, truth)
    return [f"{area:+.1%}", f"{1e3 * far:.1f}"]


def compared(seen: Array, truth: Array) -> tuple[float, float]:
    """Relative error of the area, and Hausdorff distance (m), of one outline against another."""
    a, b = resample(seen, 1500), resample(truth, 1500)
    apart = np.linalg.norm(a[:, None] - b, axis=2)
    far = max(apart.min(axis=0).max(), apart.min(axis=1).max())
    return abs(signed_area(seen) / signed_area(truth)) - 1, float(far)


def worst(results: Sequence[list[str]]) -> str:
    """The largest errors of some pictures in one cell."""
    if lost := sum(area == "not seen" for area, _ in results):
        return f"{lost} of {len(results)} not seen"
    area = max((area for area, _ in results), key=lambda text: abs(float(text.rstrip("%"))))
    return f"{area}, {max(float(far) for _, far in results):.1f} mm"


def panel(title: str, picture: Array, eye: Perception) -> Panel:
    """A picture with what is seen in it, which is in the middle."""
    seen = CAMERA.to_px(eye.observe(picture, CAMERA).contour)
    x, y = (seen.mean(axis=0) / CAMERA.pixels).tolist()
    return Panel(title, picture, seen, (x, y), height=0.36)


def markdown(rows: Sequence[Sequence[str]]) -> str:
    """A table."""
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def draw(panels: Sequence[Panel]) -> None:
    """Pictures side by side, with what is seen in red."""
    from matplotlib.figure import Figure

    from deformpush.record import palette

    figure = Figure(figsize=(9.6, 5.6), layout="constrained", dpi=100)
    for axis, shown in zip(figure.subplots(2, 3).flat, panels, strict=True):
        axis.imshow(shown.picture)
        if shown.seen is not None:
            closed = np.vstack([shown.seen, shown.seen[:1]])
            for colour, width in ((WHITE, 3.0), (palette.NEXT_PUSH, 1.4)):
                axis.plot(*closed.T, color=palette.unit(colour), linewidth=width)
        high, wide = shown.picture.shape[:2]
        x, y, half = shown.middle[0] * wide, shown.middle[1] * high, shown.height * high / 2
        axis.set(xlim=(x - 4 / 3 * half, x + 4 / 3 * half), ylim=(y + half, y - half))
        axis.set_title(shown.title, fontsize=9)
        axis.set_axis_off()
    figure.savefig(FIGURE)
    print(FIGURE.name)


if __name__ == "__main__":
    main()
