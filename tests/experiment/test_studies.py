"""The studies of conf/experiment: what they vary, and that a sweep over `hydra.sweeper.params` works."""

import math
from pathlib import Path

import pytest
from omegaconf import OmegaConf

from deformpush.config.groups import conf_dir
from deformpush.experiment.assemble import build_optimizer
from deformpush.experiment.setup import read
from deformpush.experiment.sweep import manifest
from tests.cli.test_cli import cli, runs  # noqa: F401 (fixtures)
from tests.experiment.test_sweep import sweep, table

STUDIES = {
    "study_weights": {"acq.w": 5},
    "study_kernels": {"kernel": 4, "kernel.time": 2},
    "study_initial_samples": {"optimizer.S0": 4},
    "study_stiffness": {"object.material.youngs_modulus": 5},
}


def test_every_study_is_known_here():
    found = {file.stem for file in (conf_dir() / "experiment").glob("study_*.yaml")}
    assert found == set(STUDIES)


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_makes_every_combination_and_each_can_be_built(name, cli, runs, tmp_path):  # noqa: F811
    assert (
        cli("-m", f"experiment={name}", "world=toy", "robot=tool", "seed=100", "hydra.sweep.dir=s").code == 0
    )
    jobs = manifest.read(tmp_path / "s")
    assert len({job.name for job in jobs}) == len(runs) == math.prod(STUDIES[name].values())
    assert {folder.name for _, folder in runs} == {job.name for job in jobs}
    for key, number in STUDIES[name].items():
        assert len({text for job in jobs for text in job.overrides if text.startswith(f"{key}=")}) == number
    for cfg, _ in runs:
        build_optimizer(read(OmegaConf.create(cfg)))


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_keeps_to_seeds_for_choosing(name):
    file = conf_dir() / "experiment" / f"{name}.yaml"
    assert OmegaConf.load(file).hydra.sweeper.params.seed == "range(100,105)"


def test_the_command_line_wins_over_a_study(cli, runs, tmp_path):  # noqa: F811
    cli("-m", "experiment=study_weights", "seed=7,8", "hydra.sweep.dir=s")
    assert sorted({cfg["seed"] for cfg, _ in runs}) == [7, 8]
    assert len(runs) == len(manifest.read(tmp_path / "s")) == 10


def test_a_study_without_m_is_one_line(cli, runs):  # noqa: F811
    answer = cli("experiment=study_weights")
    assert (answer.code, runs) == (2, [])
    assert answer.err == "experiment=study_weights: a study, which varies acq.w, seed; add -m\n"


def test_a_study_made_whole(tmp_path: Path):
    """Made, and the same command again makes nothing anew."""
    settings = ["experiment=study_weights", "max_pushes=3", "seed=100"]
    for _ in range(2):
        done = sweep(tmp_path, *settings)
        assert (done.returncode, done.stderr) == (0, "")
    (folder,) = (tmp_path / "runs" / "sweeps").iterdir()
    assert folder.name.startswith("experiment=study_weights_max_pushes=3_")
    rows = table(folder)
    assert [(row["acq.w"], row["state"]) for row in rows] == [
        (w, "done") for w in ("0", "0.5", "1", "2", "4")
    ]
