"""Objects of any colour on any table, and what is said where a picture does not tell them apart."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from benchmarks.rendering import Shot, cover, disc, grain, scene
from deformpush.cell.camera import Camera
from deformpush.cell.perception import Perception
from deformpush.cell.segmentation import PerceptionError
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment.setup import read
from deformpush.mechanics.geometry import resample, signed_area
from tests.pictures import RECT, lobed, placed
from tests.setups import begun, setup

CFG = compose(["object=meat", "contour=background"])
CAMERA: Camera = config.build(CFG.camera)
EYE: Perception = config.build(CFG.contour)
MEAT = config.build(CFG.object).polygon
PLACE = placed(MEAT, 0.62, 0.05, 33)
FILLET, WHITE, WOOD = (242, 237, 230), (255, 255, 255), (170, 120, 80)
HAND = np.array([(0.2, 0.3), (0.5, 0.3), (0.45, 0.1), (0.2, 0.1)])


def shown(things, table=WHITE, **shot):
    return Shot(**shot).of(scene(CAMERA, things, table))


def on(table, tmp_path, **shot) -> Perception:
    """What looks at a table that was photographed empty."""
    file = tmp_path / "empty.png"
    cv2.imwrite(str(file), Shot(seed=1, **shot).of(scene(CAMERA, [], table))[..., ::-1])
    return replace(EYE, segmentation=replace(EYE.segmentation, empty=str(file)))


def off(eye, picture):
    """Relative error of the area, and how far a contour point lies off the outline at most (m)."""
    seen = eye.observe(picture, CAMERA)
    fine = resample(PLACE, 2000)
    distance = np.linalg.norm(seen.contour[:, None] - fine, axis=2).min(axis=1)
    return abs(signed_area(seen.contour) / signed_area(PLACE) - 1), distance.max()


@pytest.mark.parametrize("colour", [FILLET, (26, 64, 230), (90, 40, 30), (60, 60, 60)])
@pytest.mark.parametrize("shot", [{"noise": 4}, {"blur": 1.5, "uneven": 0.5}], ids=str)
def test_any_colour_on_a_table_of_one(colour, shot):
    area, distance = off(EYE, shown([(PLACE, colour)], (255, 255, 255), **shot))
    assert area < 0.015
    assert distance < 1.5e-3


@pytest.mark.parametrize("light", [(1, 1, 1), (0.7, 0.7, 0.7), (0.9, 0.8, 0.6)])
def test_a_table_with_a_pattern_in_another_light(light, tmp_path):
    wood = grain(CAMERA, WOOD, 0.3)
    eye = on(wood, tmp_path, noise=2)
    area, distance = off(eye, shown([(PLACE, FILLET)], wood, light=light, uneven=0.3, noise=2, blur=1))
    assert area < 0.015
    assert distance < 1.5e-3


@pytest.mark.parametrize("rgb", [FILLET, (26, 64, 230)])
def test_a_shadow_beside_the_object_is_not_part_of_it(rgb):
    shadow = (placed(MEAT, 0.64, 0.035, 33), (-0.3,) * 3)
    picture = shown([shadow, (PLACE, rgb)], noise=2, blur=1)
    area, distance = off(EYE, picture)
    assert area < 0.03
    assert distance < 3e-3
    every = replace(EYE, segmentation=replace(EYE.segmentation, shadow=None))
    assert off(every, picture)[0] > 0.1


@pytest.mark.parametrize("seed", range(10))
def test_whatever_is_seen_is_seen_rightly(seed):
    """Objects and tables of any colour and light: right to 3 %, or refused, and never something else."""
    rng = np.random.default_rng(seed)
    table, colour = rng.integers(20, 256, 3), rng.integers(20, 256, 3)
    shot = Shot(noise=rng.uniform(0, 4), blur=rng.uniform(0, 1.5), uneven=rng.uniform(0, 0.4), seed=seed)
    truth = placed(lobed(0.08, 0.25, 3), *rng.uniform((0.45, -0.15, 0), (0.7, 0.15, 360)))
    try:
        seen = EYE.observe(shot.of(scene(CAMERA, [(truth, tuple(colour))], tuple(table))), CAMERA)
    except PerceptionError:
        assert np.ptp(colour / table) < 0.1, (
            "a colour unlike the table's, or one that is no shadow's, is seen"
        )
        return
    assert signed_area(seen.contour) == pytest.approx(signed_area(truth), rel=0.03)


def test_a_highlight_on_a_wet_object_is_part_of_it():
    picture = shown([(PLACE, (120, 60, 50)), (disc(0.62, 0.05, 0.02), WHITE)], (250, 250, 250))
    area, distance = off(EYE, picture)
    assert area < 0.01
    assert distance < 1.5e-3


CANNOT = {
    "nothing": ([], r"^no object in the picture: nothing differs from the table by 8 levels"),
    "white on white": (
        [(PLACE, (252, 252, 250))],
        r"^no object in the picture: .*\(at most 6\); an object of",
    ),
    "only a shadow": ([(PLACE, (-0.3,) * 3)], r"^no object in the picture but what looks like a shadow"),
    "grey": (
        [(PLACE, (200, 200, 200))],
        r"of the table's colour and darker; if it is the object, shadow=null",
    ),
    "a hand": (
        [(PLACE, FILLET), (HAND, (190, 140, 120))],
        r"left the picture, or something reaches over its",
    ),
    "the arm over it": (
        [(PLACE, FILLET), (placed(RECT * (3, 0.4), 0.4, 0.03, 0), (60, 60, 70))],
        r"over its rim",
    ),
    "two": ([(placed(RECT, x, 0.0, 90), FILLET) for x in (0.45, 0.7)], r"^2 objects of alike size in the"),
    "a crumb": ([(disc(0.6, 0.0, 0.01), (90, 40, 30))], r"^no object in the picture: no blob"),
    "a cloth": (
        [(RECT * 6 + (0.58, 0), (90, 40, 30))],
        r"^no object|differs from the colour of its rim|over its rim",
    ),
}


@pytest.mark.parametrize("case", CANNOT)
def test_what_one_picture_does_not_tell_is_said(case):
    things, message = CANNOT[case]
    with pytest.raises(PerceptionError, match=message):
        EYE.observe(shown(things, noise=2), CAMERA)


def test_a_camera_that_has_moved_is_noticed(tmp_path):
    cloth = np.repeat([240.0, 60.0], 40)[np.arange(480) % 80][:, None, None] * np.ones((480, 480, 3))
    eye = on(cloth, tmp_path)
    assert off(eye, shown([(PLACE, (26, 64, 230))], cloth))[0] < 0.02
    with pytest.raises(
        PerceptionError, match=r"^\d+% of the picture differs from the empty table: has the camera"
    ):
        eye.observe(shown([(PLACE, (26, 64, 230))], np.roll(cloth, 30, axis=0)), CAMERA)


def test_a_small_thing_beside_the_object_and_a_hand_later_do_no_harm():
    tool = (disc(0.4, -0.1, 0.01), (80, 80, 80))
    before = EYE.observe(shown([(PLACE, FILLET), tool]), CAMERA)
    after = EYE.observe(shown([(PLACE, FILLET), (HAND, (190, 140, 120))]), CAMERA, before)
    np.testing.assert_allclose(after.c, before.c, atol=1e-3)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "No such file or directory"),
        (b"GIF89a", "neither PNG nor JPEG"),
        (
            cv2.imencode(".png", np.zeros((99, 480, 3), np.uint8))[1].tobytes(),
            "has 480 x 99 pixels, the picture 48",
        ),
    ],
)
def test_an_empty_picture_that_will_not_do_is_one_line(content, message, tmp_path):
    file = tmp_path / "empty.png"
    if content:
        file.write_bytes(content)
    with pytest.raises(UserError, match=rf"^contour\.segmentation.*{file}.*{message}"):
        begun(setup("world=toy", "robot=tool", "contour=background", f"contour.segmentation.empty={file}"))


@pytest.mark.parametrize("world", ["toy", "mujoco", pytest.param("bullet", marks=pytest.mark.slow)])
def test_a_white_fillet_can_be_pushed_in_simulation(world):
    settings = (f"world={world}", "robot=tool", "object=fish_fillet", "record=off")
    white = begun(setup(*settings, "contour=background", "object.rgb=[0.95,0.93,0.9]"))
    blue = begun(setup(*settings))
    seen, same = white.record.view.seen, blue.record.view.seen
    assert signed_area(seen.contour) == pytest.approx(signed_area(same.contour), rel=0.01)
    np.testing.assert_allclose(seen.c, same.c, atol=5e-4)
    with pytest.raises(UserError, match="no object in the picture"):
        begun(setup(*settings, "object.rgb=[0.95,0.93,0.9]"))


def test_cover_is_the_share_of_a_pixel():
    assert cover(CAMERA, PLACE).sum() / CAMERA.scale**2 == pytest.approx(signed_area(PLACE), rel=2e-3)


def test_the_same_setting_is_read_again():
    assert read(CFG).contour == EYE
