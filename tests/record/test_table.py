"""pushes.csv keeps every digit and survives a cut."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from deformpush.record.table import COLUMNS, STRAIN, Table, read, read_rows
from deformpush.task import ERROR_COLUMNS, Errors

ACTION = ["phase", "kappa", "d", "xi", "acq", "xi_mean", "xi_std", "kappa_min", "kappa_max", "d_min", "d_max"]
ACTION += ["speed"]
BEFORE_STRAIN = COLUMNS[: COLUMNS.index("strain_p99_peak")]
"""Columns of tables from before it was measured."""


@pytest.fixture
def path(tmp_path, run):
    _, rows = run
    table = Table(tmp_path / "pushes.csv", rows[0], 0.5)
    for row in rows[1:]:
        table.append(row, 0.25)
    table.close()
    return tmp_path / "pushes.csv"


def test_every_value_comes_back_to_the_last_bit(path, run):
    frame = read(path)
    assert list(frame.columns) == COLUMNS
    for row, (_, got) in zip(run[1], frame.iterrows(), strict=True):
        assert (got["k"], got["render_s"], got["decide_s"]) == (row.k, 0.02, 0.03)
        assert [got[name] for name in ERROR_COLUMNS] == [row.errors[name] for name in ERROR_COLUMNS]
        assert got["record_s"] == (0.25 if row.k else 0.5)
        if (action := row.action) is None:
            assert (got["steps"], got["step_s"]) == (0, 0.0)
        else:
            made, strain = action.proposal, action.outcome.strain
            told = [got[name] for name in ("kappa", "d", "acq", "xi_mean", "xi_std")]
            np.testing.assert_array_equal(told, [*action.u, made.acq, made.mean, made.std])
            np.testing.assert_array_equal(
                [got["kappa_min"], got["kappa_max"], got["d_min"], got["d_max"]], made.bounds.ravel()
            )
            assert (got["phase"], got["xi"]) == (made.phase, action.xi)
            assert (got["steps"], got["step_s"]) == (480, 0.9)
            assert [got[column] for column in STRAIN] == [getattr(strain, n) for n in STRAIN.values()]
            assert got["limit_exceeded"] == (strain.p99_peak > strain.limit)
    assert set(frame["limit_exceeded"][1:]) == {0.0, 1.0}


def test_row_zero_has_empty_action_cells(path):
    with path.open(newline="") as file:
        first = next(csv.DictReader(file))
    assert first["k"] == "0"
    assert all(first[name] == "" for name in [*ACTION, *STRAIN, "limit_exceeded"])
    assert read(path)["phase"][0] == ""


def test_each_row_is_in_the_file_when_append_returns(tmp_path, run):
    _, rows = run
    table = Table(tmp_path / "t.csv", rows[0], 0.0)
    for k, row in enumerate(rows[1:], 1):
        table.append(row, 0.0)
        assert len(read(tmp_path / "t.csv")) == k + 1
    table.close()


def test_a_cut_row_is_left_out(path):
    whole = path.read_bytes()
    for cut in range(1, len(whole) - whole[:-1].rfind(b"\n") - 1):
        path.write_bytes(whole[:-cut])
        assert len(read(path)) == 14


def test_cells_of_what_is_not_measured_are_empty(tmp_path, run):
    first, row = run[1][:2]
    table = Table(tmp_path / "t.csv", first, 0.0)
    strain = row.action.outcome.strain
    for found in (None, replace(strain, limit=None)):
        outcome = replace(row.action.outcome, strain=found)
        table.append(replace(row, action=replace(row.action, outcome=outcome)), 0.0)
    table.close()
    frame = read(tmp_path / "t.csv")
    assert frame.loc[1, [*STRAIN, "limit_exceeded"]].isna().all()
    assert frame["strain_p99_peak"][2] == strain.p99_peak
    assert np.isnan(frame["limit_exceeded"][2])


def test_a_table_from_before_strain_was_measured_is_read(path):
    whole = read(path)
    old = [",".join(line.split(",")[: len(BEFORE_STRAIN)]) for line in path.read_text().splitlines()]
    assert old[0].endswith(",record_s")
    path.write_text("\n".join(old) + "\n")
    frame = read(path)
    assert list(frame.columns) == COLUMNS
    assert frame[[*STRAIN, "limit_exceeded"]].isna().all(axis=None)
    assert frame[BEFORE_STRAIN].equals(whole[BEFORE_STRAIN])


def test_a_speed_is_there_where_it_was_chosen(tmp_path, run):
    first, row = run[1][:2]
    table = Table(tmp_path / "t.csv", first, 0.0)
    for speed in (None, 0.05):
        path = replace(row.action.path, speed=speed)
        table.append(replace(row, action=replace(row.action, path=path)), 0.0)
    table.close()
    with (tmp_path / "t.csv").open(newline="") as file:
        assert [row["speed"] for row in csv.DictReader(file)][1:] == ["", "0.05"]


def test_a_force_is_there_where_it_was_measured(tmp_path, run):
    first, row = run[1][:2]
    table = Table(tmp_path / "t.csv", first, 0.0)
    outcome = replace(row.action.outcome, tool_force_peak=3.5, tool_force_mean=2.0, force_limit=3.0)
    table.append(replace(row, action=replace(row.action, outcome=outcome)), 0.0)
    table.close()
    (_, made) = read_rows(tmp_path / "t.csv")
    assert (made["tool_force_peak"], made["tool_force_mean"], made["limit_exceeded"]) == (3.5, 2.0, 1.0)


def rewritten(path, change):
    """Change the columns of a table, by name."""
    with path.open(newline="") as file:
        rows = [change(row) for row in csv.DictReader(file)]
    path.write_text("".join(",".join(row) + "\n" for row in [list(rows[0]), *map(dict.values, rows)]))


def test_a_table_of_another_version_is_read_by_name(path):
    """It lacks an error and knows another, and its columns stand in another order."""
    whole = read(path)

    def change(row):
        del row["e_gamma"]
        return {"e_tilt": "0.5", **dict(reversed(row.items()))}

    rewritten(path, change)
    frame = read(path)
    assert list(frame.columns) == [*COLUMNS, "e_tilt"]
    assert frame["e_gamma"].isna().all()
    assert (frame["e_tilt"] == 0.5).all()
    same = [name for name in COLUMNS if name != "e_gamma"]
    assert frame[same].equals(whole[same])
    assert set(read_rows(path)[0]) == {*same, "e_tilt"}


@pytest.mark.parametrize("name", ["k", "phase", "kappa", "xi", "e_T", "step_s", "d_max"])
def test_a_table_without_a_column_that_all_versions_have_is_refused(path, name):
    rewritten(path, lambda row: {key: cell for key, cell in row.items() if key != name})
    with pytest.raises(ValueError, match="not a table of pushes"):
        read(path)


def test_the_columns_of_version_0_1_keep_their_names_and_order():
    assert ",".join(COLUMNS) == (
        "k,phase,kappa,d,xi,e_c,e_theta,e_gamma,e_T,position_error_m,angle_error_rad,acq,xi_mean,xi_std,"
        "kappa_min,kappa_max,d_min,d_max,steps,step_s,render_s,decide_s,record_s,strain_p99_peak,"
        "strain_top10_peak,strain_max_peak,strain_residual,limit_exceeded,speed,tool_force_peak,tool_force_mean"
    )


def test_a_table_goes_on_after_its_first_rows(path, run):
    whole = path.read_bytes()
    table = Table.reopen(path, 10)
    for row in run[1][10:]:
        table.append(row, 0.25)
    table.close()
    assert path.read_bytes() == whole


def test_a_row_that_finds_no_room_leaves_no_trace(tmp_path, run, monkeypatch):
    table = Table(tmp_path / "t.csv", run[1][0], 0.0)
    before = (tmp_path / "t.csv").read_bytes()

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", full)
        with pytest.raises(OSError, match="No space left"):
            table.append(run[1][1], 0.0)
    assert (tmp_path / "t.csv").read_bytes() == before
    table.append(run[1][1], 0.0)
    table.close()
    assert len(read(tmp_path / "t.csv")) == 2


def test_infinite_values_come_back(tmp_path, run):
    first = run[1][0]
    odd = replace(first, errors=Errors({**first.errors.values, "e_T": np.inf, "e_gamma": -np.inf}))
    Table(tmp_path / "t.csv", odd, 0.0).close()
    assert read(tmp_path / "t.csv").loc[0, ["e_T", "e_gamma"]].tolist() == [np.inf, -np.inf]


@pytest.mark.parametrize("text", [b"", b"k,phase\n0,\n", b"\xff\xfe\x00\n", b"k"])
def test_another_file_is_refused(tmp_path, text):
    (tmp_path / "t.csv").write_bytes(text)
    with pytest.raises(ValueError, match="not a table of pushes"):
        read(tmp_path / "t.csv")
