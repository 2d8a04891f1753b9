"""A goal given as a picture: it becomes an outline, and the run needs the file no more."""

import json

import cv2
import numpy as np
import pytest

from deformpush.errors import UserError
from deformpush.experiment.run import make_run
from deformpush.record.saved_config import read_config
from tests.outlines import ell
from tests.pictures import picture, placed
from tests.setups import begun, setup

POINTS = json.dumps(ell(0.15, 0.05).tolist())
RUN = ["world=toy", "robot=tool", "record=off", "optimizer=greedy", "stop=strict", f"object.outline={POINTS}"]


@pytest.fixture
def file(tmp_path):
    """The L at its goal, as the run's camera sees it."""
    image = picture(setup(*RUN).camera, placed(ell(0.15, 0.05), 0.55, 0.1, 140))
    cv2.imwrite(str(tmp_path / "goal.png"), image[..., ::-1])
    return tmp_path / "goal.png"


def test_a_run_goes_where_the_picture_shows_and_keeps_the_outline(file, tmp_path):
    made = make_run(setup(*RUN, f"task.goal.picture={file}", "max_pushes=60"), tmp_path / "run")
    assert made.status == "reached"
    assert made.errors["position_error_m"] < 0.01
    kept = read_config(tmp_path / "run" / "config.yaml")["task"]["goal"]
    assert kept["picture"] == str(file)
    outline = np.array(kept["outline"])
    assert np.linalg.norm(outline.mean(axis=0) - placed(ell(0.15, 0.05), 0.55, 0.1, 140).mean(axis=0)) < 0.02
    file.unlink()
    again = setup(*RUN, f"task.goal.outline={json.dumps(outline.tolist())}", "max_pushes=60")
    assert make_run(again, tmp_path / "again").pushes == made.pushes


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda file: file.unlink(), "No such file"),
        (lambda file: file.write_bytes(b"no picture"), "goal.png: "),
        (lambda file: cv2.imwrite(str(file), np.zeros((100, 80, 3), np.uint8)), "has 80 x 100 pixels"),
        (lambda file: cv2.imwrite(str(file), np.full((480, 480, 3), 255, np.uint8)), "no object in the pict"),
    ],
)
def test_a_picture_that_shows_no_goal_is_refused_before_anything_is_written(file, tmp_path, spoil, message):
    spoil(file)
    with pytest.raises(UserError, match=f"^task.goal.picture = {file}: .*{message}|{message}"):
        make_run(setup(*RUN, f"task.goal.picture={file}"), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_picture_that_nobody_looked_at_is_no_goal(file):
    with pytest.raises(UserError, match="not looked at yet"):
        begun(setup(*RUN, f"task.goal.picture={file}"))
