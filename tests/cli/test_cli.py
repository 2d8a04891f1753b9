"""The command line: what reaches the run, exit codes, and one clear line for each mistake."""

import logging
import subprocess
import sys
import types
from dataclasses import dataclass
from pathlib import Path

import pytest

from deformpush import __main__, __version__
from deformpush.cli import usage
from deformpush.config.groups import option_groups
from deformpush.errors import UserError
from tests.mistakes import MISTAKES

ROOT = Path(__file__).resolve().parents[2]
HEAVY = {"torch", "scipy", "numpy", "pandas", "matplotlib", "rerun", "pybullet", "cv2", "pydantic"}


FAILED = types.SimpleNamespace(status="failed")
"""How a run ended, as far as the command line asks."""


@dataclass
class Answer:
    code: int
    out: str
    err: str


def stand_in(monkeypatch, make):
    """Let `make` stand for the making of single runs and of those of sweeps."""
    monkeypatch.setattr("deformpush.experiment.run.make_run", make)
    monkeypatch.setattr(
        "deformpush.experiment.sweep.run_or_resume.make_run",
        lambda made, folder, verbosity: make(made, folder),
    )


@pytest.fixture
def runs(monkeypatch):
    """Runs asked for, as (settings, folder), in place of runs made."""
    made = []

    stand_in(monkeypatch, lambda setup, folder: made.append((setup.values, Path(folder))))
    return made


@pytest.fixture
def cli(monkeypatch, capfd, tmp_path):
    """Run the command line in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HYDRA_FULL_ERROR", "0")
    monkeypatch.setattr(sys, "path", list(sys.path))
    handlers = list(logging.root.handlers)

    def run(*argv: str) -> Answer:
        monkeypatch.setattr(sys, "argv", ["deformpush", *argv])
        with pytest.raises(SystemExit) as leaving:
            __main__.main()
        out, err = capfd.readouterr()
        return Answer(leaving.value.code, out, err)

    yield run
    logging.root.handlers[:] = handlers


def test_help_lists_verbs_groups_and_options(cli):
    answer = cli("--help")
    assert answer.code == 0
    for group, options in option_groups().items():
        assert f"\n  {group:<13}{', '.join(options)}\n" in answer.out
    for verb in usage.VERBS:
        assert f"\n  {verb} " in answer.out
    assert "  object       rect, " in answer.out  # the default first


def test_help_lists_the_users_own_objects(cli, tmp_path):
    (tmp_path / "mine" / "object").mkdir(parents=True)
    (tmp_path / "mine" / "object" / "dough.yaml").touch()
    assert "dough" in cli("--config-dir", "mine", "--help").out
    assert "dough" in cli("--config-dir=mine", "-h").out


def test_version(cli):
    assert cli("--version").out == f"deformpush {__version__}\n"


@pytest.mark.parametrize("argv", [["--help"], ["--cfg", "job"]])
def test_questions_are_answered_without_heavy_imports(argv):
    code = (
        f"import sys; sys.argv[1:] = {argv!r}\n"
        "from deformpush.__main__ import main\n"
        "try: main()\n"
        "except SystemExit as leaving: assert not leaving.code\n"
        f"print(sorted({HEAVY} & set(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stderr == "[]\n"


def test_a_run_gets_the_whole_configuration(cli, runs, tmp_path):
    assert cli("object=meat", "acq.w=2.5", "seed=3", "acquisition=lcb").code == 0
    ((cfg, folder),) = runs
    assert (cfg["seed"], cfg["acq"]["w"], cfg["object"]["thickness"]) == (3, 2.5, 0.01)
    assert cfg["options"]["object"] == "meat"
    assert cfg["options"]["acquisition"] == "lcb"
    assert "hydra" not in cfg
    assert folder.parent.parent == tmp_path / "runs"
    assert folder.name.endswith("-meat-lcb-s3")


def test_the_run_folder_may_be_named(cli, runs, tmp_path):
    assert cli("hydra.run.dir=there").code == 0
    assert runs[0][1] == tmp_path / "there"
    assert list((tmp_path / "there").iterdir()) == []


def test_a_sweep_makes_every_run_in_a_folder_named_by_its_overrides(cli, runs, tmp_path):
    assert cli("-m", "seed=0,1", "acq.w=0.5,1", "hydra.sweep.dir=sweep").code == 0
    assert [(c["seed"], c["acq"]["w"]) for c, _ in runs] == [(0, 0.5), (0, 1), (1, 0.5), (1, 1)]
    assert runs[1][1] == tmp_path / "sweep" / "acq.w=1,seed=0"


def test_one_bad_run_does_not_stop_a_sweep(cli, monkeypatch):
    seen = []

    def make(setup, folder):
        seen.append(setup.seed)
        if setup.seed == 0:
            raise UserError("seed = 0: not today")
        return FAILED if setup.seed == 1 else None

    stand_in(monkeypatch, make)
    answer = cli("-m", "seed=0,1,2")
    assert seen == [0, 1, 2]
    assert answer.code == 2
    assert answer.err == "seed = 0: not today\n"


def test_a_bug_in_one_run_does_not_stop_a_sweep(cli, monkeypatch):
    seen = []

    def make(setup, folder):
        seen.append(setup.seed)
        if setup.seed == 0:
            raise ZeroDivisionError("a bug")

    stand_in(monkeypatch, make)
    answer = cli("-m", "seed=0,1,2")
    assert seen == [0, 1, 2]
    assert answer.code == 1
    assert "ZeroDivisionError: a bug" in answer.err


def test_ctrl_c_in_a_sweep_leaves_a_table_of_it(cli, monkeypatch, tmp_path):
    def make(setup, folder):
        if setup.seed == 1:
            raise KeyboardInterrupt

    stand_in(monkeypatch, make)
    answer = cli("-m", "seed=0,1,2", "hydra.sweep.dir=here")
    assert answer.code == 130
    assert "here: 3 runs" in answer.out
    assert (tmp_path / "here" / "sweep.csv").read_text().count("\n") == 4


def test_the_exit_code_is_that_of_the_run(cli, monkeypatch):
    stand_in(monkeypatch, lambda setup, folder: FAILED)
    assert cli().code == 1
    stand_in(monkeypatch, lambda setup, folder: types.SimpleNamespace(status="budget"))
    assert cli().code == 0


def test_ctrl_c_is_no_traceback(cli, monkeypatch):
    def make(setup, folder):
        raise KeyboardInterrupt

    stand_in(monkeypatch, make)
    answer = cli()
    assert (answer.code, answer.err) == (130, "interrupted\n")


def test_an_error_of_the_program_keeps_its_traceback(monkeypatch, cli):
    def make(setup, folder):
        raise ValueError("a bug")

    stand_in(monkeypatch, make)
    monkeypatch.setattr(sys, "argv", ["deformpush"])
    with pytest.raises(ValueError, match="a bug"):
        __main__.main()


def test_a_refused_run_leaves_no_folder_and_touches_none(cli, monkeypatch, tmp_path):
    def make(setup, folder):
        raise UserError("object.d: too long")

    stand_in(monkeypatch, make)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "pushes.csv").write_text("k\n0\n")
    before = (tmp_path / "full" / "pushes.csv").stat()
    assert cli("hydra.run.dir=empty").code == 2
    assert not (tmp_path / "empty").exists()
    assert cli("hydra.run.dir=full").code == 2
    assert [p.name for p in (tmp_path / "full").iterdir()] == ["pushes.csv"]
    assert (tmp_path / "full" / "pushes.csv").stat().st_mtime_ns == before.st_mtime_ns


def test_config_dir_brings_objects_and_classes_of_the_user(cli, tmp_path, monkeypatch):
    mine = tmp_path / "mine"
    (mine / "acquisition").mkdir(parents=True)
    (mine / "acquisition" / "own.yaml").write_text("# @package acq\n_target_: own_acquisition.Own\nz: 3\n")
    (mine / "own_acquisition.py").write_text(
        "from deformpush.optimizer.acquisition import Acquisition\n"
        "class Own(Acquisition):\n"
        "    def __init__(self, z: int):\n        self.z = z\n"
        "    def objective(self, context):\n        raise NotImplementedError\n"
    )
    built = []
    stand_in(monkeypatch, lambda setup, folder: built.append(setup.acq))
    assert cli("--config-dir", "mine", "acquisition=own", "acq.z=4").code == 0
    assert built[0].z == 4


def test_settings_may_stand_on_both_sides_of_a_flag(cli, runs, tmp_path):
    (tmp_path / "mine" / "object").mkdir(parents=True)
    (tmp_path / "mine" / "object" / "thin.yaml").write_text("defaults: [rect, _self_]\nthickness: 0.004\n")
    assert cli("seed=3", "--config-dir", "mine", "object=thin").code == 0
    assert (runs[0][0]["seed"], runs[0][0]["object"]["thickness"]) == (3, 0.004)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("thickness: [1,\n", "bad.yaml, line 2: not YAML: expected the node content, but found"),
        ("a:\n\t- b\n", "bad.yaml, line 2: not YAML: found character"),
        ("defaults: [rct, _self_]\n", "object=rct: no such option (did you mean rect?); options of object: "),
    ],
)
def test_a_file_of_the_user_that_cannot_be_read_is_one_line(text, message, cli, tmp_path):
    (tmp_path / "mine" / "object").mkdir(parents=True)
    (tmp_path / "mine" / "object" / "bad.yaml").write_text(text)
    answer = cli("--config-dir", "mine", "object=bad")
    assert message in answer.err
    assert (answer.code, answer.out, answer.err.count("\n")) == (2, "", 1)


def test_the_flags_are_those_of_hydra():
    from hydra._internal.utils import get_args_parser

    theirs = {name: a.nargs != 0 for a in get_args_parser()._actions for name in a.option_strings}
    assert theirs == usage.FLAGS


def test_a_verb_gets_the_rest_of_the_line(cli, monkeypatch):
    module = types.ModuleType("deformpush.cli.sing")
    module.main = lambda argv: print(argv) or 7
    monkeypatch.setitem(sys.modules, "deformpush.cli.sing", module)
    monkeypatch.setitem(usage.VERBS, "sing", "a song")
    answer = cli("sing", "--loud", "x=1")
    assert (answer.code, answer.out) == (7, "['--loud', 'x=1']\n")


def test_every_verb_has_its_module(cli):
    for verb in usage.VERBS:
        assert (ROOT / "deformpush" / "cli" / f"{verb}.py").exists()


@pytest.mark.parametrize("line", MISTAKES)
def test_a_mistake_is_one_line_and_exit_code_2(line, cli, tmp_path):
    answer = cli(*line.split())
    assert answer.err.startswith(MISTAKES[line])
    assert answer.err.count("\n") == 1
    assert (answer.code, answer.out) == (2, "")
    assert not list(tmp_path.glob("**/*.*")), "a mistake leaves no file behind"


def test_a_mistake_in_a_process_of_its_own():
    command = [sys.executable, "-m", "deformpush", "object=fish"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 2
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)
