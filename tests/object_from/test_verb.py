"""The verb `object from`: what it asks, says and writes, and that what it writes can be pushed."""

import re
import shlex
import sys

import cv2
import numpy as np
import pytest
import yaml

from deformpush import __main__
from deformpush.cli import object as verb
from deformpush.config.groups import conf_dir
from deformpush.errors import UserError
from deformpush.record.saved_config import read_config
from tests.object_from.making import write
from tests.outlines import OUTLINES, fish
from tests.pages import ROOT
from tests.rendered import photo

PLATE = "0,0\n120,0\n120,70\n0,70\n"
MM = ("--unit", "mm")
SHIPPED = ("fish_whole", "ring", "ell", "dough_round")


@pytest.fixture
def plate(tmp_path, monkeypatch):
    """An empty folder with a plate in a file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plate.csv").write_text(PLATE)
    return tmp_path


def from_(*argv: str) -> int:
    return verb.main(["from", *argv, "--out", "mine"])


def test_it_writes_yaml_and_picture_and_says_what_it_saw(plate, capsys):
    assert from_("plate.csv", *MM, "--like", "tofu", "--thickness", "15") == 0
    said = capsys.readouterr().out
    assert "outline:   4 points within 0.00 mm; 120 x 70 mm" in said
    assert re.search(
        r"mesh:      cell .* mm, .* tetrahedra; smallest angle .* degrees, .*thinnest neck .* cells", said
    )
    own = yaml.safe_load((plate / "mine" / "object" / "plate.yaml").read_text())
    assert own["defaults"] == ["tofu", "_self_"]
    assert own["outline"] == [[-0.06, -0.035], [0.06, -0.035], [0.06, 0.035], [-0.06, 0.035]]
    assert own["thickness"] == 0.015
    picture = cv2.imread(str(plate / "mine" / "object" / "plate.png"))
    assert picture.shape[0] > 300
    command = re.search(r"push it:   (python -m deformpush .*)", said)[1]
    assert "--config-dir mine object=plate world=mujoco robot=tool" in command
    assert sorted(p.name for p in (plate / "mine" / "object").iterdir()) == ["plate.png", "plate.yaml"]


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        ((), r"^plate.csv: states no unit; --unit mm\|cm\|m\|in or --length MM must say how large it is$"),
        (
            ("--mm-per-px", "1"),
            r"^--mm-per-px: is for pictures; for plate.csv there are --unit and --length$",
        ),
        ((*MM, "--name", "rect"), r"^--name rect: deformpush has an object of that name"),
        ((*MM, "--name", "../up"), r"^--name '../up': must begin with a letter"),
        ((*MM, "--name", "null"), r"^--name 'null': must begin with a letter"),
        ((*MM, "--like", "tofo"), r"^--like tofo: no such object \(did you mean tofu\?\)"),
        ((*MM, "--thickness", "900"), r"^plate.csv: (cell|thickness): |^object.thickness"),
        ((*MM, "--cell", "80"), r"^plate.csv: cell: 0.08 m "),
        (("--unit", "m"), r"^plate.csv: outline: is 120 m long, must be 0.02 to 1 m"),
    ],
)
def test_what_it_asks_and_refuses(plate, argv, message):
    with pytest.raises(UserError, match=message) as refused:
        from_("plate.csv", *argv)
    assert refused.value.exit_code == 2
    assert "\n" not in str(refused.value)
    assert not (plate / "mine").exists()


def test_a_picture_without_a_scale_is_told_the_flags(plate):
    write(plate / "a.png", photo(OUTLINES["ell"])[0])
    flags = "--mm-per-px X, --marker MM, --charuco-square MM, --length MM"
    with pytest.raises(UserError, match=f"^a.png: how large is it\\? One of {flags} must say so$"):
        from_("a.png")


def test_nothing_is_overwritten_unless_it_is_told_to(plate):
    from_("plate.csv", *MM)
    file = plate / "mine" / "object" / "plate.yaml"
    file.write_text("kept")
    with pytest.raises(UserError, match="exists already; --overwrite replaces it"):
        from_("plate.csv", *MM)
    assert file.read_text() == "kept"
    from_("plate.csv", *MM, "--overwrite")
    assert "outline" in file.read_text()


def test_the_known_length_of_its_longer_side(plate, capsys):
    """That of the outline without its noise."""
    image, _ = photo(OUTLINES["rect"], mm_per_px=0.8, turn=0.4)
    write(plate / "a.png", image)
    from_("a.png", "--length", "200")
    assert re.search(r", 200 mm long, (99|100) mm wide", capsys.readouterr().out)
    from_("plate.csv", "--length", "60")
    assert "; 60 x 35 mm" in capsys.readouterr().out


def test_pieces_and_holes_are_told(plate, capsys):
    image = np.full((200, 300, 3), 230, np.uint8)
    cv2.rectangle(image, (30, 30), (190, 150), (60, 60, 60), -1)
    cv2.circle(image, (110, 90), 20, (230, 230, 230), -1)
    cv2.circle(image, (240, 90), 20, (60, 60, 60), -1)
    write(plate / "a.png", image)
    from_("a.png", "--mm-per-px", "1")
    said = capsys.readouterr().out
    assert re.search(r"pieces:    2; the largest is the object, the others cover 6\.\d% of its area", said)
    assert re.search(r"holes:     1 filled, 6\.\d% of its area", said)
    assert "161 x 121 mm" in said


def test_what_is_too_thin_to_mesh_is_cut_off_and_that_is_told(plate, capsys):
    """A plate with a fin 2 mm wide."""
    rows = [(0, 0), (150, 0), (150, 40), (210, 41), (210, 43), (150, 44), (150, 90), (0, 90)]
    (plate / "fin.csv").write_text("\n".join(f"{x},{y}" for x, y in rows))
    from_("fin.csv", *MM)
    said = capsys.readouterr().out
    assert re.search(
        r"cut off:   1 part at \[\d+, \S+\] mm, thinner than \d+\.\d mm, 1\.\d% of its area; a sm", said
    )
    assert re.search(r"; 1[5-9]\d x 90 mm", said)


def test_a_bow_tie_is_mended_and_that_is_told(plate, capsys):
    (plate / "tie.csv").write_text("0,0\n100,80\n100,0\n0,60\n")
    from_("tie.csv", *MM)
    assert "mended:    a line crosses itself" in capsys.readouterr().out


def test_a_name_of_a_file_puts_nothing_into_the_yaml(plate):
    odd = plate / "a\n_target_: os.system\n.csv"
    odd.write_text(PLATE)
    from_(odd.name, *MM, "--name", "odd")
    text = (plate / "mine" / "object" / "odd.yaml").read_text()
    assert not re.search(r"^_target_", text, re.MULTILINE)
    assert set(yaml.safe_load(text)) <= {"defaults", "outline", "thickness", "cell", "d", "dt", "material"}


def test_the_mass_of_another_size_is_that_of_its_material(plate):
    from_("plate.csv", *MM, "--like", "meat")
    own = yaml.safe_load((plate / "mine" / "object" / "plate.yaml").read_text())
    assert own["material"] == {"mass": None, "density": pytest.approx(0.3 / (0.020272 * 0.01), rel=1e-3)}
    assert (own["goal_mask"], own["e_gamma_stop"]) == (None, 0.15)


@pytest.mark.parametrize("name", SHIPPED)
def test_the_shipped_objects_are_what_the_verb_makes_of_their_files(name, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    text = (conf_dir() / "object" / f"{name}.yaml").read_text(encoding="utf-8")
    command = shlex.split(text.splitlines()[1].removeprefix("# python -m deformpush "))
    assert command[:2] == ["object", "from"]
    at = command.index("--out") + 1
    assert command[at] == "conf"
    command[at] = str(tmp_path)
    if "--name" not in command:
        command += ["--name", name]
    monkeypatch.setattr(verb, "_shipped", lambda *_: False)
    verb.main(command[1:])
    made, there = (yaml.safe_load(t) for t in ((tmp_path / "object" / f"{name}.yaml").read_text(), text))
    if name == "fish_whole":  # a photo: another build of OpenCV may round otherwise
        np.testing.assert_allclose(made.pop("outline"), there.pop("outline"), atol=2e-4)
    assert made == there


def test_from_the_picture_of_a_fish_to_a_finished_run_in_two_commands(plate, monkeypatch, capfd):
    image, _ = photo(fish(0.2), turn=0.2, colours=((150, 172, 140), (92, 96, 120)))
    write(plate / "fish.png", image)
    commands = [
        "object from fish.png --mm-per-px 1 --like fish_fillet --cell 12 --out my_conf",
        "--config-dir my_conf object=fish world=mujoco robot=tool optimizer=abo_motion max_pushes=2 "
        "record=off hydra.run.dir=run",
    ]
    for command in commands:
        monkeypatch.setattr(sys, "argv", ["deformpush", *command.split()])
        with pytest.raises(SystemExit) as leaving:
            __main__.main()
        assert leaving.value.code == 0, capfd.readouterr().err
    assert (plate / "run" / "summary.json").is_file()
    assert len((plate / "run" / "pushes.csv").read_text().splitlines()) == 1 + 3
    used = read_config(plate / "run" / "config.yaml")["object"]
    assert (
        used["outline"] == yaml.safe_load((plate / "my_conf" / "object" / "fish.yaml").read_text())["outline"]
    )
    assert used["strain_limit"] == 0.1
