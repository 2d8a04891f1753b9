"""pushes.csv keeps every digit and survives a cut."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from deformpush.push_record import COLUMNS
from deformpush.record.table import STRAIN, Table, read

ACTION = ["phase", "kappa", "d", "xi", "acq", "xi_mean", "xi_std", "kappa_min", "kappa_max", "d_min", "d_max"]
ACTION += ["speed"]
BEFORE_STRAIN = COLUMNS[: COLUMNS.index("strain_p99_peak")]
"""Of tables from before it was measured."""


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
        for name in set(COLUMNS) - set(ACTION) - set(STRAIN) - {"record_s", "limit_exceeded"}:
            assert got[name] == getattr(row, name)
        assert got["record_s"] == (0.25 if row.k else 0.5)
        if row.decision is not None:
            names = ("kappa", "d", "acq", "xi_mean", "xi_std")
            told = [got[name] for name in names]
            made = [getattr(row.decision, name) for name in names]
            np.testing.assert_array_equal(told, made)
            np.testing.assert_array_equal(
                [got["kappa_min"], got["kappa_max"], got["d_min"], got["d_max"]], row.decision.bounds.ravel()
            )
            assert (got["phase"], got["xi"]) == (row.decision.phase, row.xi)
            assert [got[column] for column in STRAIN] == [getattr(row.strain, n) for n in STRAIN.values()]
            assert got["limit_exceeded"] == (row.strain.p99_peak > row.strain.limit)
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
    table.append(replace(row, strain=None), 0.0)
    table.append(replace(row, strain=replace(row.strain, limit=None)), 0.0)
    table.close()
    frame = read(tmp_path / "t.csv")
    assert frame.loc[1, [*STRAIN, "limit_exceeded"]].isna().all()
    assert frame["strain_p99_peak"][2] == row.strain.p99_peak
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


def test_infinite_values_come_back(tmp_path, run):
    odd = replace(run[1][0], e_T=float("inf"), e_gamma=float("-inf"))
    Table(tmp_path / "t.csv", odd, 0.0).close()
    assert read(tmp_path / "t.csv").loc[0, ["e_T", "e_gamma"]].tolist() == [np.inf, -np.inf]


@pytest.mark.parametrize("text", [b"", b"k,phase\n0,\n", b"\xff\xfe\x00\n", b"k"])
def test_another_file_is_refused(tmp_path, text):
    (tmp_path / "t.csv").write_bytes(text)
    with pytest.raises(ValueError, match="not a table of pushes"):
        read(tmp_path / "t.csv")
