"""What `deformpush.run` refuses, in the line that the command line prints."""

import pytest

import deformpush
from tests.mistakes import MISTAKES

TOY = ("world=toy", "robot=tool", "record=off")


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """What is not refused after all leaves its folder there."""
    monkeypatch.chdir(tmp_path)


SETTINGS = [
    line for line in MISTAKES if not line.startswith(("-", "docter", "=", "seed=1 ", "hydra", "+hydra"))
]


@pytest.mark.parametrize("line", SETTINGS)
def test_a_mistake_is_told_as_on_the_command_line(line, tmp_path):
    with pytest.raises(deformpush.UserError) as caught:
        deformpush.run(*TOY, *line.split(), progress=False)
    assert caught.value.line.startswith(MISTAKES[line])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("values", "begins"),
    [
        ({"seed": -1}, "seed = -1: must be a whole number of 0 or more"),
        ({"seed": 1.5}, "seed = 1.5: must be a whole number of 0 or more"),
        ({"sede": 1}, "sede: unknown (did you mean seed?); groups and settings: "),
        ({"object": "rct"}, "object=rct: no such option (did you mean rect?); options of object: "),
    ],
)
def test_a_wrong_keyword_is_told_as_on_the_command_line(values, begins):
    with pytest.raises(deformpush.UserError) as caught:
        deformpush.run(*TOY, progress=False, **values)
    assert caught.value.line.startswith(begins)


def test_a_study_is_not_one_run():
    with pytest.raises(deformpush.UserError, match=r"experiment=study_weights: a study, which varies acq\.w"):
        deformpush.run(*TOY, "experiment=study_weights", progress=False)


@pytest.mark.parametrize("setting", ["hydra.run.dir=here", "sweep.retry=true", "hydra/launcher=basic"])
def test_settings_of_the_command_line_itself_are_refused(setting):
    with pytest.raises(deformpush.UserError, match=f"{setting}: for the command line alone"):
        deformpush.run(*TOY, setting)


def test_a_full_folder_is_refused(tmp_path):
    (tmp_path / "pushes.csv").touch()
    with pytest.raises(deformpush.UserError, match="already holds results"):
        deformpush.run(*TOY, folder=tmp_path, progress=False)
