"""The verb `see`: what is told of a picture, what is written and used, and what is refused."""

import re

import cv2
import numpy as np
import pytest

from benchmarks.real_camera import camera as real_camera
from benchmarks.real_camera import sheet_views
from benchmarks.rendering import Shot, grain, scene
from deformpush.cell.camera import Camera
from deformpush.cli import see
from deformpush.config import build as config
from deformpush.config.compose import compose
from deformpush.config.groups import conf_dir
from deformpush.config.locate import use_config_dir
from deformpush.errors import UserError
from deformpush.mechanics.geometry import signed_area
from tests.cell.test_background import CANNOT, FILLET, PLACE, WHITE, WOOD
from tests.setups import begun, setup

CAMERA: Camera = config.build(compose([]).camera)
BOTTOM = str(conf_dir() / "camera" / "bottom.yaml")
RED = (200, 40, 30)


@pytest.fixture
def shot(tmp_path, monkeypatch):
    """Take a picture of things on a table, into a file of the working directory."""
    monkeypatch.chdir(tmp_path)

    def take(name: str, things, table=WHITE, **how):
        cv2.imwrite(name, Shot(**how).of(scene(CAMERA, things, table))[..., ::-1])
        return name

    return take


def told(capsys) -> dict[str, str]:
    return dict(re.findall(r"^(\w+): +(.*)$", capsys.readouterr().out, re.MULTILINE))


def numbers(text: str) -> list[float]:
    return [float(found) for found in re.findall(r"-?\d+\.?\d*", text)]


def observed(*settings: str):
    """What a run with these settings would see in a picture of the place where PLACE is."""
    return config.build(compose([*settings]).contour)


@pytest.mark.parametrize("colour", [FILLET, pytest.param(RED, marks=pytest.mark.slow)])
def test_colours_are_found_and_used(colour, shot, capsys):
    shot("thing.png", [(PLACE, colour)], (220, 220, 215), noise=2, blur=1)
    assert see.main(["thing.png", "--camera", BOTTOM, "--out", "my_conf"]) == 0
    said = told(capsys)
    assert said["by"].startswith("1 range of colour: hue ")
    area, long, wide = numbers(said["area"].replace("cm2", ""))
    assert area == pytest.approx(signed_area(PLACE) * 1e4, rel=0.025)
    assert long > wide
    assert numbers(said["pose"])[:2] == pytest.approx((1e3 * PLACE.mean(axis=0)).tolist(), abs=5)
    eye = observed(use_config_dir("my_conf"), "contour=thing")
    again = cv2.imread("thing.png")[..., ::-1].copy()
    assert signed_area(eye.observe(again, CAMERA).contour) == pytest.approx(area / 1e4, rel=1e-3)


def test_a_picture_of_the_empty_table_is_kept_and_used(shot, capsys, tmp_path):
    wood = grain(CAMERA, WOOD, 0.4)
    shot("thing.png", [(PLACE, (80, 90, 85))], wood * 0.8, noise=2, seed=1)
    shot("table.png", [], wood, noise=2, seed=2)
    assert (
        see.main(
            ["thing.png", "--empty", "table.png", "--out", "my_conf", "--name", "dough", "--by", "background"]
        )
        == 0
    )
    said = told(capsys)
    assert said["by"] == "difference from a picture of the empty table"
    (tmp_path / "table.png").unlink()
    eye = observed(use_config_dir("my_conf"), "contour=dough")
    seen = eye.observe(cv2.imread("thing.png")[..., ::-1].copy(), CAMERA)
    assert signed_area(seen.contour) == pytest.approx(signed_area(PLACE), rel=0.03)


def test_a_run_sees_what_see_has_found(shot, tmp_path):
    white = ("world=toy", "robot=tool", "object.rgb=[0.95,0.93,0.9]")
    picture = begun(setup(*white, "contour=background")).record.view.picture
    cv2.imwrite("fillet.png", picture[..., ::-1])
    assert see.main(["fillet.png", "--out", "my_conf", "--camera", BOTTOM]) == 0
    assert see.main(["fillet.png", "--out", "my_conf", "--camera", BOTTOM, "--overwrite"]) == 0
    assert "ranges" in (tmp_path / "my_conf" / "contour" / "fillet.yaml").read_text()
    seen = begun(setup(*white, use_config_dir("my_conf"), "contour=fillet")).record.view.seen
    assert signed_area(seen.contour) == pytest.approx(0.02, rel=0.02)


@pytest.mark.parametrize(
    ("scale", "unit"), [pytest.param((), "px", marks=pytest.mark.slow), (("--mm-per-px", "0.5"), "mm")]
)
def test_a_photo_of_any_size_from_its_lower_left_corner(scale, unit, shot, capsys):
    image = np.full((750, 1500, 3), 255, np.uint8)
    image[550:650, 300:600] = RED
    cv2.imwrite("photo.png", image[..., ::-1])
    argv = ["photo.png", *scale, "--out", "my_conf"]
    assert see.main(argv) == 0
    said = told(capsys)
    factor = 0.5 if scale else 1.0
    assert numbers(said["pose"])[:3] == pytest.approx([450 * factor, 150 * factor, 0], abs=2)
    assert numbers(said["area"].replace("cm2", ""))[1:] == pytest.approx([300 * factor, 100 * factor], abs=3)
    assert unit in said["pose"]
    drawn = cv2.imread("photo_seen.png")
    assert drawn.shape[1] == 1280
    assert (np.abs(drawn.astype(int) - (28, 25, 215)).max(axis=2) < 30).sum() > 1000, "the outline is drawn"
    for again in (argv, argv[:-2]):
        with pytest.raises(UserError, match=r"photo_seen\.png.* exists already; --overwrite replaces it"):
            see.main(again)


@pytest.mark.parametrize("case", ["nothing", "only a shadow", "a hand", "two"])
def test_what_a_picture_does_not_tell_is_one_line_and_nothing_is_written(case, shot, tmp_path):
    things, message = CANNOT[case]
    shot("photo.png", things, noise=2)
    with pytest.raises(UserError, match=message.replace("^", r"^photo\.png: ")) as caught:
        see.main(["photo.png", "--camera", BOTTOM, "--out", "my_conf"])
    assert "\n" not in str(caught.value)
    assert {path.name for path in tmp_path.rglob("*.*")} == {"photo.png"}


def test_one_points_at_the_object_where_the_table_has_many_colours(shot, capsys):
    table = grain(CAMERA, (120, 160, 90), 0.6) + grain(CAMERA, (0, 0, 60), 1.0, seed=3).transpose(1, 0, 2)
    shot("thing.png", [(PLACE, RED), ((PLACE - PLACE.mean(axis=0)) * 0.5 + (0.4, -0.2), RED)], table, noise=3)
    with pytest.raises(UserError, match=r"^thing\.png: .*(a table with a pattern needs a picture|no object)"):
        see.main(["thing.png"])
    x, y = CAMERA.to_px(PLACE.mean(axis=0))
    assert see.main(["thing.png", "--on", f"{x:.0f}", f"{y:.0f}", "--camera", BOTTOM]) == 0
    said = told(capsys)
    assert numbers(said["area"].replace("cm2", ""))[0] == pytest.approx(signed_area(PLACE) * 1e4, rel=0.02)
    with pytest.raises(UserError, match=r"^--on 5000 3: is outside of the picture"):
        see.main(["thing.png", "--on", "5000", "3", "--overwrite"])


HOSTILE = {
    "nothing": (lambda path: None, "No such file or directory"),
    "a folder": (lambda path: path.mkdir(), "no regular file"),
    "text": (lambda path: path.write_text("hello"), "neither PNG nor JPEG"),
    "cut": (lambda path: path.write_bytes(png((480, 480))[:300]), "damaged, cannot be decoded"),
    "huge": (lambda path: path.write_bytes(claiming(50_000)), "50000 x 50000 pixels, 1 to 8192 a side"),
    "a bomb": (lambda path: path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"0" * 64_000_001), "larger than 64 MB"),
}


def png(size: tuple[int, int]) -> bytes:
    return cv2.imencode(".png", np.random.default_rng(0).integers(0, 255, (*size, 3), np.uint8))[1].tobytes()


def claiming(side: int) -> bytes:
    data = bytearray(png((8, 8)))
    data[16:24] = side.to_bytes(4, "big") * 2
    return bytes(data)


@pytest.mark.parametrize("case", HOSTILE)
@pytest.mark.parametrize("flag", [[], ["good.png", "--empty"], ["--square", "25", "--calibrate"]], ids=str)
def test_a_file_that_is_no_picture_is_one_line(case, flag, shot, tmp_path):
    make, message = HOSTILE[case]
    shot("good.png", [(PLACE, RED)])
    make(tmp_path / "bad.png")
    with pytest.raises(UserError, match=rf"^bad\.png: {message}"):
        see.main([*flag, "bad.png"])


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        ([], r"^see: needs one of PICTURE, --print-sheet FILE and --calibrate"),
        (["a.png", "--print-sheet", "b.png"], r"^see: needs one of"),
        (["good.png", "--name", "../x"], r"^--name \.\./x: must be a name"),
        (["good.png", "--mm-per-px", "0"], r"^--mm-per-px 0: must be 0\.001 to 100"),
        (["good.png", "--mm-per-px", "nan"], r"^--mm-per-px nan: must be 0\.001 to 100"),
        (["good.png", "--camera", "none.yaml"], r"^--camera none\.yaml: No such file"),
        (["good.png", "--camera", "bad.yaml"], r"^--camera bad\.yaml: camera\._target_ = os\.system: "),
        (
            ["good.png", "--empty", "other.png"],
            r"^--empty other\.png: must be as large as good\.png",
        ),
        (["small.png"], r"^small\.png: is 10 x 20 pixels .*too small"),
        (
            ["--calibrate", "good.png", "--square", "25", "--at", "nan", "0", "0"],
            r"^--at nan 0\.0 0\.0: must be ",
        ),
        (
            ["small.png", "--camera", BOTTOM],
            r"^small\.png: has 10 x 20 pixels, the camera's pictures 480",
        ),
        (["--calibrate", "good.png"], r"^--square MM: missing"),
        (["--calibrate", "good.png", "--square", "0"], r"^--square 0: must be 1 to 1000 mm"),
        (
            ["--calibrate", "good.png", "--square", "25"],
            r"^--calibrate: the first picture, .* shows 0 of its corn",
        ),
        (["--print-sheet", "a.svg"], r"^--print-sheet a\.svg: must end in \.png or \.pdf"),
    ],
)
def test_a_mistake_is_one_line(argv, message, shot, tmp_path):
    shot("good.png", [(PLACE, RED)])
    cv2.imwrite("small.png", np.zeros((20, 10, 3), np.uint8))
    cv2.imwrite("other.png", np.zeros((20, 30, 3), np.uint8))
    (tmp_path / "bad.yaml").write_text("_target_: os.system\ncommand: touch x\n")
    with pytest.raises(UserError, match=message):
        see.main(argv)


@pytest.mark.parametrize("name", ["sheet.png", "sheet.pdf"])
def test_the_sheet_is_written_once(name, tmp_path, capsys):
    assert see.main(["--print-sheet", str(tmp_path / name)]) == 0
    assert "10 squares are 250 mm" in capsys.readouterr().out
    with pytest.raises(UserError, match=rf"{name} exists already"):
        see.main(["--print-sheet", str(tmp_path / name)])


def test_a_calibrated_camera_is_written_and_used(shot, capsys, tmp_path):
    true = real_camera((0.62, 0.1, -0.8), (0.58, 0.0, 0.0))
    names = [f"view-{n}.jpg" for n in range(5)]
    for name, view in zip(
        names, sheet_views(true, 5, 0.025, (0.58, 0.0), Shot(noise=2, blur=0.7)), strict=True
    ):
        cv2.imwrite(name, view)
    assert see.main(["--calibrate", *names, "--square", "25", "--out", "my_conf"]) == 0
    said = told(capsys)
    assert said["pictures"].startswith("5 of 5 used")
    assert said["place"] == "0.800 m below the table"
    assert numbers(said["error"])[-1] < 2
    with pytest.raises(UserError, match=r"calibrated\.yaml exists already"):
        see.main(["--calibrate", *names, "--square", "25", "--out", "my_conf"])
    mine = use_config_dir("my_conf")
    settings = ("world=toy", "robot=tool", "object=meat")
    real, ideal = (begun(setup(*settings, *more)) for more in ((mine, "camera=calibrated"), ()))
    seen, same = real.record.view.seen, ideal.record.view.seen
    assert real.record.view.picture.shape == (real.cell.camera.pixels,) * 2 + (3,)
    assert real.cell.world.picture().shape == true.shape
    np.testing.assert_allclose(seen.c, same.c, atol=1e-3)
    assert signed_area(seen.contour) == pytest.approx(signed_area(same.contour), rel=0.01)
    with pytest.raises(UserError, match=r"^view-0.jpg: no object in the picture|^view-0.jpg: .*differs"):
        see.main(["view-0.jpg", "--camera", "my_conf/camera/calibrated.yaml", "--empty", "view-0.jpg"])
