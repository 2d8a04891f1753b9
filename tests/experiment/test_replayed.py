"""A replay of a run from elsewhere tells a last bit from a real difference, and what may be the reason."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deformpush.cell.perception import Perception
from deformpush.cell.world import WorldError
from deformpush.cli import replay
from deformpush.experiment.origin import differing, origin
from deformpush.experiment.run import make_run
from deformpush.record.folder import RunFolder
from deformpush.record.provenance import provenance
from deformpush.worlds.toy import ToyWorld
from tests.cli.test_replay import RUN


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("made") / "run"
    make_run(RUN, folder)
    return folder


@pytest.fixture
def run(made, tmp_path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "run"))


def told(run: Path, capsys) -> list[str]:
    assert replay.main([str(run)]) == 1
    return capsys.readouterr().out.splitlines()


def moved(monkeypatch, by_m: dict[int, float]) -> None:
    """Let the object lie elsewhere in x after some pushes, as another machine's arithmetic does."""
    push, calls = ToyWorld.push, []

    def otherwise(self, path):
        outcome = push(self, path)
        calls.append(1)
        self.c = np.add(self.c, (by_m.get(len(calls), 0.0), 0.0))
        return outcome

    monkeypatch.setattr(ToyWorld, "push", otherwise)


def seen(monkeypatch, at: int, by_m: float) -> None:
    """Let the camera see everything elsewhere in x in one picture; row 0 is the first."""
    observe, calls = Perception.observe, []

    def otherwise(self, *args):
        view = observe(self, *args)
        calls.append(1)
        if len(calls) != at + 1:
            return view
        shift = np.array([by_m, 0.0])
        return replace(view, contour=view.contour + shift, c=view.c + shift)

    monkeypatch.setattr(Perception, "observe", otherwise)


def test_a_last_bit_inside_the_world_does_not_show(run, capsys, monkeypatch):
    moved(monkeypatch, {3: 3e-17})
    assert replay.main([str(run)]) == 0
    assert capsys.readouterr().out == "identical: 12 pushes, errors and contours to the last bit\n"


def test_a_value_on_the_brink_between_two_roundings_is_a_last_bit(run, capsys, monkeypatch):
    seen(monkeypatch, 3, 1e-7)
    states, decisions, origin = told(run, capsys)
    assert states.startswith("differs in the last bit, first at push 3: the contour by 1e-07 m, ")
    assert states.endswith("; grows no further in 12 pushes")
    assert decisions.startswith("decides ")
    assert origin.startswith("made with ")


def test_its_growth_is_told_with_size_and_push(run, capsys, monkeypatch):
    seen(monkeypatch, 3, 1e-7)
    moved(monkeypatch, {7: 6e-3})
    states, decisions, _ = told(run, capsys)
    assert states.startswith("differs in the last bit, first at push 3: the contour by 1e-07 m, ")
    grown, at = states.split("grows to ")[1].split(" mm at push ")
    assert float(grown) > 4.0
    assert int(at.split(";")[0]) >= 7
    assert decisions.startswith("decides otherwise: really, first at push 11: ")


def test_a_push_that_cannot_be_made_any_more_is_told_and_nothing_is_raised(run, capsys, monkeypatch):
    push, calls = ToyWorld.push, []

    def failing(self, path):
        calls.append(1)
        if len(calls) == 5:
            raise WorldError("out of reach")
        return push(self, path)

    monkeypatch.setattr(ToyWorld, "push", failing)
    states, failure, origin = told(run, capsys)
    assert states == "identical: 4 pushes, errors and contours to the last bit"
    assert failure == "fails at push 5, which was made then: out of reach"
    assert origin.startswith("made with ")


def test_the_least_that_a_camera_shows_is_a_pixel(run, capsys, monkeypatch):
    moved(monkeypatch, {5: 3e-4})
    states, _, _ = told(run, capsys)
    assert states.startswith("differs by a pixel at most, first at push ")


def test_three_pixels_are_a_real_difference(run, capsys, monkeypatch):
    moved(monkeypatch, {5: 4.4e-3})
    states, _, _ = told(run, capsys)
    assert states.startswith("differs really, first at push 5: the contour by 4.")


def doctored(run: Path, **change: object) -> None:
    file = run / "provenance.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), **change}))


def last_bit(run: Path) -> None:
    """Another last digit in row 6."""
    rows = (run / "pushes.csv").read_text().splitlines()
    cells = rows[7].split(",")
    cells[8] = repr(np.nextafter(float(cells[8]), 1.0).item())
    rows[7] = ",".join(cells)
    (run / "pushes.csv").write_text("\n".join(rows) + "\n")


def test_versions_and_kernels_of_both_machines_are_told_where_they_differ(run, capsys):
    last_bit(run)
    here = provenance()
    blas = [{**one, "kernel": "Haswell2"} for one in here["kernels"]["blas"]]
    doctored(
        run,
        git=None,
        python="3.11.1",
        packages={**here["packages"], "numpy": "1.0", "ruff": "0"},
        kernels={**here["kernels"], "blas": blas, "numpy": []},
    )
    line = told(run, capsys)[2]
    assert line.startswith("made with BLAS ")
    assert line.endswith(": which may be the reason")
    for text in ("Haswell2", "numpy's instructions none (here ", "python 3.11.1 (here ", "numpy 1.0 (here "):
        assert text in line
    assert "ruff" not in line, "it computes nothing"


def test_the_same_versions_and_kernels_leave_a_change_as_the_reason(run, capsys):
    last_bit(run)
    doctored(run, git=None)
    assert told(run, capsys)[2].startswith("made with the same versions and kernels as here: ")


@pytest.mark.parametrize(
    ("content", "why"), [(None, "no provenance.json"), ("{", "provenance.json is damaged: not JSON")]
)
def test_without_provenance_the_reason_is_not_known(content, why, run, capsys):
    last_bit(run)
    (run / "provenance.json").unlink()
    if content:
        (run / "provenance.json").write_text(content)
    assert told(run, capsys)[2] == f"where it was made is not known: {why}"


def test_the_part_of_a_resumed_run_is_asked_that_made_the_push(tmp_path):
    parts = [{"after": 4, "python": "3.0.4"}, {"after": 9, "python": "3.0.9"}]
    (tmp_path / "provenance.json").write_text(json.dumps({"python": "3.0.0", "resumed": parts}))
    lines = {k: origin(RunFolder(tmp_path), k) for k in (4, 5, 9, 10)}
    shown = {k: line.split("python ")[1].split(" ")[0] for k, line in lines.items()}
    assert shown == {4: "3.0.0", 5: "3.0.4", 9: "3.0.4", 10: "3.0.9"}


def test_what_a_file_says_stays_in_its_line():
    (line,) = differing({"machine": "x\n" * 900}, provenance())
    assert "\n" not in line
    assert len(line) < 120
