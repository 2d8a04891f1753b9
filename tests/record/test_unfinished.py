"""What a run left is taken up as it stands in its table."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.record import checkpoint
from deformpush.record.folder import RunFolder
from deformpush.record.table import COLUMNS, FORCE, Table, read_rows
from deformpush.record.unfinished import differences, read
from deformpush.task import Errors


@pytest.fixture
def rows(run):
    """Those of the made-up run, the last one at a speed of its own."""
    *rows, last = run[1]
    action = replace(last.action, path=replace(last.action.path, speed=0.05))
    return [*rows, replace(last, action=action)]


@pytest.fixture
def folder(tmp_path, rows):
    folder = RunFolder(tmp_path)
    table = Table(folder.table, rows[0], 0.5)
    for row in rows[1:]:
        table.append(row, 0.25)
    table.close()
    return folder


def test_a_row_gives_the_push_that_was_made(folder, rows):
    unfinished = read(folder)
    assert unfinished.pushes == 14
    for row in rows[1:]:
        found, made = unfinished.proposal(row.k), row.action.proposal
        np.testing.assert_array_equal(found.u, row.action.u)
        np.testing.assert_array_equal(found.bounds, made.bounds)
        assert found.phase == made.phase
        np.testing.assert_array_equal([found.acq, found.mean, found.std], [made.acq, made.mean, made.std])
    assert unfinished.proposal(13).speed is None
    assert unfinished.proposal(14).speed == 0.05


def test_a_table_without_speeds_leaves_them_to_the_world(folder):
    lines = [line.split(",") for line in folder.table.read_text().splitlines()]
    kept = [i for i, name in enumerate(lines[0]) if name not in ("speed", *FORCE)]
    folder.table.write_text("".join(",".join(line[i] for i in kept) + "\n" for line in lines))
    unfinished = read(folder)
    assert not unfinished.current, "no row can be added to it"
    assert unfinished.proposal(14).speed is None


def test_the_table_of_this_version_is_current(folder):
    unfinished = read(folder)
    assert unfinished.current
    assert list(unfinished.rows[0]) == COLUMNS


def test_nothing_is_left_where_nothing_was_written(tmp_path):
    unfinished = read(RunFolder(tmp_path))
    assert (unfinished.rows, unfinished.pushes, unfinished.checkpoint) == ([], 0, None)
    assert unfinished.current


@pytest.mark.parametrize(("k", "usable"), [(0, False), (1, True), (14, True), (15, False)])
def test_a_checkpoint_counts_if_it_follows_a_push_of_the_table(folder, k, usable):
    checkpoint.write(folder.checkpoint, k, {"a": 1})
    found = read(folder).checkpoint
    assert (found is not None) == usable


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [("\n3,", "\n4,", "row 3 says k = 4"), ("\n3,initial,", "\n3,initial,,", "not a table of pushes")],
)
def test_rows_that_are_not_those_of_one_run_are_refused(folder, old, new, reason):
    folder.table.write_text(folder.table.read_text().replace(old, new, 1))
    with pytest.raises(ValueError, match=reason):
        read(folder)


def test_a_row_without_a_push_is_refused(folder):
    lines = folder.table.read_text().splitlines()
    cells = lines[3].split(",")
    cells[COLUMNS.index("kappa")] = ""
    lines[3] = ",".join(cells)
    folder.table.write_text("\n".join(lines) + "\n")
    with pytest.raises(ValueError, match="row 2 names no push"):
        read(folder)


def told(found, record) -> str:
    """The first difference, in words."""
    return str(differences(found, record)[0])


def test_the_same_push_does_not_differ(folder, rows):
    for found, row in zip(read_rows(folder.table), rows, strict=True):
        assert differences(found, row) == []
        slower = replace(row, timing=replace(row.timing, decide_s=9.0))
        assert differences(found, slower) == [], "times are never compared"


def test_what_differs_is_named_to_the_last_bit(folder, rows):
    found, row = read_rows(folder.table)[4], rows[4]
    nearly = float(np.nextafter(row.errors["e_c"], 1.0))
    other = replace(row, errors=Errors({**row.errors.values, "e_c": nearly}))
    assert told(found, other) == f"e_c is {nearly!r} and was {row.errors['e_c']!r}"
    faster = replace(row, action=replace(row.action, path=replace(row.action.path, speed=0.1)))
    assert told(found, faster) == "speed is 0.1 and was nan"


def test_thoughts_and_what_an_older_table_lacks_are_not_compared(folder, rows):
    found, row = read_rows(folder.table)[4], rows[4]
    thought = replace(row.action.proposal, phase="explore", mean=0.3, bounds=np.zeros((2, 2)))
    assert differences(found, replace(row, action=replace(row.action, proposal=thought))) == []
    unstrained = replace(row.action, outcome=replace(row.action.outcome, strain=None))
    now = replace(row, action=unstrained)
    assert told(found, now).startswith("strain_p99_peak is nan")
    older = {name: value for name, value in found.items() if "strain" not in name}
    assert differences({k: v for k, v in older.items() if k != "limit_exceeded"}, now) == []
